// A minimal PTM decoder for ptm-conform: java Decoder.java VIEW FILE, or java Decoder.java serve.
import java.io.*;
import java.nio.charset.StandardCharsets;
import java.nio.file.*;
import java.util.regex.*;

class Decoder {
    static final String SCALE = "[+-]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][+-]?\\d+)?", BIAS = "[+-]?\\d+", BREAK = "(?: +| ?\n)";
    static final Pattern HEADER = Pattern.compile(String.format(
        "PTM_1\\.2 ?\n(PTM_FORMAT_\\w+) ?\n(\\d{1,9})%3$s(\\d{1,9}) ?\n(%1$s(?: +%1$s){5})%3$s(%2$s(?: +%2$s){5}) ?\n", SCALE, BIAS, BREAK));
    /** Exit status 65: the file is malformed. 69: the kind of file or the view is not supported. */
    static class Refusal extends Exception { final int status; Refusal(int status) { this.status = status; } }
    record Image(int width, int height, int channels, String type, byte[] samples) {}

    /** To do: return the image of a view. Samples are u8 or f32, texel by texel, top row first.
     *  This example decodes the stored values of PTM_FORMAT_LRGB: all polynomials, then all colors, bottom row first. */
    static Image decode(String view, byte[] file) throws Refusal {
        Matcher header = HEADER.matcher(new String(file, StandardCharsets.ISO_8859_1));
        if (!view.equals("raw") || header.lookingAt() && !header.group(1).equals("PTM_FORMAT_LRGB")) throw new Refusal(69);
        if (!header.lookingAt()) throw new Refusal(65);
        var numbers = java.util.stream.Stream.of((header.group(4) + " " + header.group(5)).split(" +"));
        if (numbers.map(Double::valueOf).anyMatch(n -> n.isInfinite())) throw new Refusal(65);
        int width = Integer.parseInt(header.group(2)), height = Integer.parseInt(header.group(3)), start = header.end();
        long count = (long) width * height;
        if (count == 0 || file.length < start + 9 * count) throw new Refusal(65);
        byte[] samples = new byte[(int) (9 * count)];
        for (int i = 0; i < count; i++) {
            int to = 9 * ((height - 1 - i / width) * width + i % width);
            System.arraycopy(file, start + 6 * i, samples, to, 6);
            System.arraycopy(file, (int) (start + 6 * count + 3 * i), samples, to + 6, 3);
        }
        return new Image(width, height, 9, "u8", samples);
    }
    // Answers a request and returns the exit status. In one-shot mode, there is no sequence number.
    static int answer(String sequence, String view, String path, PrintStream out) throws IOException {
        try {
            Image image = decode(view, Files.readAllBytes(Path.of(path)));
            String line = "PTM1 " + view.split(":")[0] + " " + image.width + " " + image.height + " " + image.channels + " " + image.type + "\n";
            out.print(sequence == null ? line : sequence + " ok " + (line.length() + image.samples.length) + "\n" + line);
            out.write(image.samples);
            return 0;
        } catch (Refusal refusal) {
            if (sequence != null) out.print(sequence + (refusal.status == 65 ? " reject 65\n" : " unsupported\n"));
            return refusal.status;
        }
    }

    public static void main(String[] words) throws IOException {
        PrintStream out = new PrintStream(new BufferedOutputStream(new FileOutputStream(FileDescriptor.out)));
        BufferedReader requests = new BufferedReader(new InputStreamReader(System.in, StandardCharsets.UTF_8));
        int status = 0;
        if (words[0].equals("capabilities")) out.print("protocol: 1\nname: my-decoder\nmodes: [one-shot, serve]\npipelined: true\n");
        else if (words[0].equals("serve"))
            for (String line; (line = requests.readLine()) != null; out.flush())
                answer(line.split(" ", 3)[0], line.split(" ", 3)[1], line.split(" ", 3)[2], out);
        else status = answer(null, words[0], words[1], out);
        out.flush();
        System.exit(status);
    }
}
