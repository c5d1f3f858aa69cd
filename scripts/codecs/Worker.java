import java.awt.image.BufferedImage;
import java.awt.image.Raster;
import java.io.*;
import java.nio.charset.StandardCharsets;
import javax.imageio.*;
import javax.imageio.stream.*;

/** ImageIO of the JDK as a plane codec, with the protocol of worker.py: java Worker.java NAME. */
public class Worker {
    public static void main(String[] arguments) throws IOException {
        ImageIO.setUseCache(false);
        var input = new DataInputStream(new BufferedInputStream(System.in));
        var output = new BufferedOutputStream(System.out);
        for (String line; (line = readLine(input)) != null; ) {
            String[] words = line.split(" ");
            byte[] body = input.readNBytes(Integer.parseInt(words[words.length - 1]));
            try {
                byte[] answer = words[0].equals("decode") ? decode(arguments[0], body) : encode(words, body);
                output.write(answer);
            } catch (Exception | Error problem) {
                output.write(("error " + String.valueOf(problem).replaceAll("\\s+", " ") + "\n").getBytes(StandardCharsets.US_ASCII));
            }
            output.flush();
        }
    }

    static byte[] decode(String name, byte[] stream) throws IOException {
        ImageReader reader = ImageIO.getImageReadersByFormatName("jpeg").next();
        try {
            reader.setInput(new MemoryCacheImageInputStream(new ByteArrayInputStream(stream)));
            if (name.equals("java-raster")) {
                Raster raster = reader.read(0).getRaster();
                int[] samples = raster.getPixels(0, 0, raster.getWidth(), raster.getHeight(), (int[]) null);
                return answer(raster.getWidth(), raster.getHeight(), raster.getNumBands(), samples);
            }
            BufferedImage image = reader.read(0);
            int[] pixels = image.getRGB(0, 0, image.getWidth(), image.getHeight(), null, 0, image.getWidth());
            int[] samples = new int[pixels.length * 3];
            for (int i = 0; i < samples.length; i++) samples[i] = pixels[i / 3] >> (16 - 8 * (i % 3)) & 255;
            return answer(image.getWidth(), image.getHeight(), 3, samples);
        } finally {
            reader.dispose();
        }
    }

    static byte[] encode(String[] words, byte[] samples) throws IOException {
        int width = Integer.parseInt(words[1]), height = Integer.parseInt(words[2]);
        var image = new BufferedImage(width, height, BufferedImage.TYPE_BYTE_GRAY);
        image.getRaster().setDataElements(0, 0, width, height, samples);
        ImageWriter writer = ImageIO.getImageWritersByFormatName("jpeg").next();
        ImageWriteParam parameters = writer.getDefaultWriteParam();
        parameters.setCompressionMode(ImageWriteParam.MODE_EXPLICIT);
        parameters.setCompressionQuality(Integer.parseInt(words[3]) / 100f);
        var out = new ByteArrayOutputStream();
        try (var target = new MemoryCacheImageOutputStream(out)) {
            writer.setOutput(target);
            writer.write(null, new IIOImage(image, null, null), parameters);
        }
        byte[] stream = out.toByteArray();
        return join("ok 0 0 0 " + stream.length + "\n", stream);
    }

    static byte[] answer(int width, int height, int channels, int[] samples) {
        byte[] bytes = new byte[samples.length];
        for (int i = 0; i < samples.length; i++) bytes[i] = (byte) samples[i];
        return join("ok " + width + " " + height + " " + channels + " " + bytes.length + "\n", bytes);
    }

    static byte[] join(String line, byte[] bytes) {
        var out = new ByteArrayOutputStream();
        out.writeBytes(line.getBytes(StandardCharsets.US_ASCII));
        out.writeBytes(bytes);
        return out.toByteArray();
    }

    static String readLine(InputStream input) throws IOException {
        var line = new StringBuilder();
        for (int c; (c = input.read()) != '\n'; line.append((char) c)) if (c < 0) return null;
        return line.toString();
    }
}
