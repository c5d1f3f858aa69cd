/* A minimal PTM decoder for ptm-conform: ./decoder VIEW FILE, or ./decoder serve. To build: cc -O2 -o decoder decoder.c -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
typedef struct { unsigned long width, height, channels; int is_real; unsigned char *samples; size_t size; } Image;
/* Cuts the next word off the header and sets its separator: ' ' for spaces, '\n' for a line feed after at most one space, or 0. */
static char *next_word(char **rest, int *separator) {
    char *word = *rest, *end = word + strcspn(word, " \n");
    size_t spaces = strspn(end, " ");
    *rest = end + spaces;
    *separator = **rest == '\n' && spaces < 2 ? *(*rest)++ : spaces > 0 ? ' ' : 0;
    *end = 0;
    return word;
}

/* To do: set the image of a view, or return 65 for malformed files, 69 for unsupported files or views. Samples are u8 or f32,
 * texel by texel, top row first. This example decodes PTM_FORMAT_LRGB: all polynomials, then all colors, bottom row first. */
static int decode(const char *view, char *file, size_t size, Image *image) {
    const char *ends = "\n\n*\n     *     \n"; /* '*' is a space or a line feed */
    char *rest = file, *words[16], *end;
    for (int i = 0; i < 16; i++) {
        int separator, wanted = ends[i];
        words[i] = next_word(&rest, &separator);
        int is_other = i == 1 && !strncmp(words[1], "PTM_FORMAT_", 11) && strcmp(words[1], "PTM_FORMAT_LRGB");
        if (strcmp(view, "raw") || is_other) return 69;
        if (separator == 0 || (wanted != '*' && wanted != separator)) return 65;
        size_t sign = i > 3 && (words[i][0] == '+' || words[i][0] == '-');
        size_t used = sign + strspn(words[i] + sign, i > 3 && i < 10 ? "+-.0123456789eE" : "0123456789");
        if (i > 1 && (words[i][used] || used == sign || !isfinite(strtod(words[i], &end)) || *end)) return 65;
    }
    size_t w = strtoul(words[2], NULL, 10), h = strtoul(words[3], NULL, 10), n = w * h, left = size - (size_t)(rest - file);
    if (strcmp(words[0], "PTM_1.2") || strcmp(words[1], "PTM_FORMAT_LRGB") || w == 0 || h == 0 || left / 9 / w < h) return 65;
    *image = (Image){w, h, 9, 0, malloc(9 * n), 9 * n};
    for (size_t i = 0; i < n; i++) {
        unsigned char *to = image->samples + 9 * ((h - 1 - i / w) * w + i % w);
        memcpy(to, rest + 6 * i, 6), memcpy(to + 6, rest + 6 * n + 3 * i, 3);
    }
    return 0;
}
/* Answers a request and returns the exit status. In one-shot mode, there is no sequence number. */
static int answer(const char *sequence, const char *view, const char *path) {
    Image image = {0};
    FILE *in = fopen(path, "rb");
    if (!in || fseek(in, 0, SEEK_END)) return 2;
    size_t size = (size_t)ftell(in);
    char line[128], *file = calloc(size + 1, 1);
    int status = !fseek(in, 0, SEEK_SET) && file && fread(file, 1, size, in) == size ? decode(view, file, size, &image) : 2;
    int length = sprintf(line, "PTM1 %.*s %lu %lu %lu %s\n", (int)strcspn(view, ":"), view, image.width, image.height,
                         image.channels, image.is_real ? "f32" : "u8");
    if (sequence && status) printf("%s %s\n", sequence, status == 65 ? "reject 65" : "unsupported");
    else if (sequence) printf("%s ok %zu\n", sequence, (size_t)length + image.size);
    if (!status) fwrite(line, 1, (size_t)length, stdout), fwrite(image.samples, 1, image.size, stdout);
    return fflush(stdout), fclose(in), free(file), free(image.samples), status;
}
int main(int count, char **words) {
    char request[8192];
    if (count == 2 && !strcmp(words[1], "capabilities")) return puts("protocol: 1\nname: my-decoder\nmodes: [one-shot, serve]\npipelined: true") < 0;
    while (count == 2 && fgets(request, sizeof request, stdin)) { /* SEQ VIEW PATH */
        char *view = strchr(request, ' ') + 1, *path = strchr(view, ' ') + 1;
        view[-1] = path[-1] = path[strcspn(path, "\n")] = 0, answer(request, view, path);
    }
    return count == 3 ? answer(NULL, words[1], words[2]) : 0;
}
