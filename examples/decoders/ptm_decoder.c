/*
 * Reads a Polynomial Texture Map, version 1.2, in its four simplest formats, and answers in PTM-CP 1.
 *
 *     ptm_decoder VIEW FILE       VIEW is raw, coef or rgb:LU,LV; one frame on standard output
 *     ptm_decoder capabilities    the capabilities of this decoder, in YAML
 *
 *     cc -std=c99 -O2 -o ptm_decoder ptm_decoder.c
 *
 * Exit status: 0 decoded, 65 malformed, 69 unsupported (LUM, the compressed formats, other views), 1 no memory or no file.
 * The sections are in the order of the specification. If it leaves a question open, the name of the ruling follows in
 * brackets, as in [rows].
 */

#include <errno.h>
#include <stdint.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#endif

enum { MALFORMED = 65, UNSUPPORTED = 69 };

/* The bytes of the file, and the current position. */
typedef struct {
    const unsigned char *bytes;
    size_t size, at;
} Source;

/* A map. `texels` has `channels` bytes for each texel, left to right, top row first. */
typedef struct {
    size_t width, height;
    int channels;               /* 18: red a0..a5, green, blue; 9: a0..a5, R, G, B */
    double scale[6], bias[6];
    unsigned char *texels;
} Map;

static void fail(int status, const char *why)
{
    fprintf(stderr, "%s: %s\n", status == MALFORMED ? "malformed" : status == UNSUPPORTED ? "unsupported" : "error", why);
    exit(status);
}

static void *allocate(size_t count, size_t size)
{
    void *memory = size != 0 && count > SIZE_MAX / size ? NULL : malloc(count * size + 1);
    if (memory == NULL)
        fail(1, "not enough memory");
    return memory;
}

/* 2.0 File format: header lines, then bytes */

/*
 * Returns a copy of the next header line, which the caller frees. The line consists of printable words that are separated
 * by one or more spaces, with at most one space before its end [header-line-end, header-blanks].
 */
static char *next_line(Source *source)
{
    const unsigned char *start = source->bytes + source->at;
    const unsigned char *end = memchr(start, '\n', source->size - source->at);
    size_t length, i;
    char *line;

    if (end == NULL)
        fail(MALFORMED, "the header ends without a line feed");
    length = (size_t)(end - start);
    source->at += length + 1;
    line = allocate(length + 1, 1);
    memcpy(line, start, length);
    if (length > 0 && line[length - 1] == ' ')
        length--;
    line[length] = '\0';
    for (i = 0; i < length; i++)
        if (line[i] < ' ' || line[i] > '~')
            fail(MALFORMED, "a header line contains bytes that are not printable");
    if (length == 0 || line[0] == ' ' || line[length - 1] == ' ')
        fail(MALFORMED, "a header line is empty or has extra spaces");
    return line;
}

/* Returns the next word of a line, or NULL. The word is terminated in place. */
static char *next_word(char **rest)
{
    char *word = *rest + strspn(*rest, " ");
    char *end = word + strcspn(word, " ");

    if (*word == '\0')
        return NULL;
    *rest = *end == '\0' ? end : end + 1;
    *end = '\0';
    return word;
}

/* Returns 1 for [+-]? (digits [. digits?] | . digits) ([eE] [+-]? digits)? and nothing else [numbers]. */
static int is_number(const char *word)
{
    size_t whole, part = 0;

    word += *word == '+' || *word == '-';
    whole = strspn(word, "0123456789");
    word += whole;
    if (*word == '.') {
        part = strspn(++word, "0123456789");
        word += part;
    }
    if (whole + part == 0)
        return 0;
    if (*word == 'e' || *word == 'E') {
        word++;
        word += *word == '+' || *word == '-';
        whole = strspn(word, "0123456789");
        if (whole == 0)
            return 0;
        word += whole;
    }
    return *word == '\0';
}

static double number(const char *word)
{
    double value = is_number(word) ? strtod(word, NULL) : HUGE_VAL;

    if (value == HUGE_VAL || value == -HUGE_VAL)
        fail(MALFORMED, "a number is malformed or not finite");
    return value;
}

/* Returns a number above 0. Numbers that do not fit in size_t are malformed, because no such file can exist [dimensions]. */
static size_t positive_integer(const char *word)
{
    size_t value = 0;

    word += *word == '+';
    if (*word == '\0' || word[strspn(word, "0123456789")] != '\0')
        fail(MALFORMED, "a size is not a positive integer");
    for (; *word != '\0'; word++) {
        if (value > (SIZE_MAX - 9) / 10)
            fail(MALFORMED, "a size is too large");
        value = value * 10 + (size_t)(*word - '0');
    }
    if (value == 0)
        fail(MALFORMED, "a size is 0");
    return value;
}

/* Returns the next `count` times `size` bytes. This checks the length before any allocation [payload-end]. */
static const unsigned char *take(Source *source, size_t count, size_t size)
{
    const unsigned char *bytes = source->bytes + source->at;

    if (count > (source->size - source->at) / size)
        fail(MALFORMED, "the file is too short");
    source->at += count * size;
    return bytes;
}

/* 2.1 Header string */

static void read_version(Source *source)
{
    char *line = next_line(source);

    if (strcmp(line, "PTM_1.2") != 0)           /* [version] PTM_1.1 has a different layout. */
        fail(MALFORMED, "the first line is not PTM_1.2");
    free(line);
}

/* 2.2 Format string */

typedef enum { RGB, LRGB, LUT, C_LUT } Format;

static Format read_format(Source *source)
{
    static const char *const read[] = {
        "PTM_FORMAT_RGB", "PTM_FORMAT_LRGB", "PTM_FORMAT_PTM_LUT", "PTM_FORMAT_PTM_C_LUT"
    };
    static const char *const known[] = {
        "PTM_FORMAT_LUM", "PTM_FORMAT_JPEG_RGB", "PTM_FORMAT_JPEG_LRGB", "PTM_FORMAT_JPEGLS_RGB", "PTM_FORMAT_JPEGLS_LRGB"
    };
    char *line = next_line(source);
    size_t i;

    for (i = 0; i < sizeof read / sizeof *read; i++)
        if (strcmp(line, read[i]) == 0) {
            free(line);
            return (Format)i;
        }
    for (i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(line, known[i]) == 0)
            fail(UNSUPPORTED, known[i]);
    fail(MALFORMED, "unknown format");
    return RGB;
}

/* 2.3 and 2.4: `first` words on one line and the rest on the next, or all on one line [size-spelling] */

typedef struct {
    char *lines[2], *words[12];                             /* The words point into the lines. */
    size_t count;
} Words;

static void add_line(Source *source, Words *words, int line)
{
    char *rest = words->lines[line] = next_line(source), *word;

    while ((word = next_word(&rest)) != NULL) {
        if (words->count == 12)
            fail(MALFORMED, "a header line has too many words");
        words->words[words->count++] = word;
    }
}

static Words read_words(Source *source, size_t count, size_t first)
{
    Words words = { { NULL, NULL }, { NULL }, 0 };

    add_line(source, &words, 0);
    if (words.count == first)
        add_line(source, &words, 1);
    if (words.count != count)
        fail(MALFORMED, "a header line has too few or too many words");
    return words;
}

static void free_words(Words *words)
{
    free(words->lines[0]);
    free(words->lines[1]);
}

/* 2.3 Image size */

static void read_size(Source *source, Map *map)
{
    Words words = read_words(source, 2, 1);

    map->width = positive_integer(words.words[0]);
    map->height = positive_integer(words.words[1]);
    free_words(&words);
    if (map->width > SIZE_MAX / map->height)
        fail(MALFORMED, "the size is too large");
}

/* 2.4 Scale and bias */

static void read_scale_and_bias(Source *source, Map *map)
{
    Words words = read_words(source, 12, 6);
    int i;

    for (i = 0; i < 6; i++) {
        map->scale[i] = number(words.words[i]);
        map->bias[i] = number(words.words[6 + i]);
        if (map->bias[i] != floor(map->bias[i]))            /* [odd-numbers] 3.0 is an integer. */
            fail(MALFORMED, "a bias is not an integer");
    }
    free_words(&words);
}

/* Returns the final value of a channel: (raw - bias) * scale in real arithmetic [final-coefficient]. */
static double final_value(const Map *map, const unsigned char *texel, int channel)
{
    int coefficients = map->channels == 18 ? 18 : 6;        /* The bytes after a5 are colors, which stay as stored. */

    return channel < coefficients ? (texel[channel] - map->bias[channel % 6]) * map->scale[channel % 6] : texel[channel];
}

/* 2.5 Lookup table */

typedef struct {
    size_t count, width;                                    /* number of entries, and bytes per entry */
    const unsigned char *entries;
} Table;

static Table read_table(Source *source, Format format)
{
    Table table = { 0, format == C_LUT ? 9 : 6, NULL };
    char *line = next_line(source), *rest = line;
    char *first = next_word(&rest), *second = next_word(&rest), *third = next_word(&rest);

    /* [lut-count] "256 N_LUT_ENTRIES", "256" or "nentries 256" */
    if (second != NULL && strcmp(first, "nentries") == 0)
        first = second;
    else if (second != NULL && strcmp(second, "N_LUT_ENTRIES") != 0)
        fail(MALFORMED, "not a number of entries");
    if (third != NULL)
        fail(MALFORMED, "not a number of entries");
    table.count = positive_integer(first);
    free(line);
    table.entries = take(source, table.count, table.width);    /* [lut-newline] The indices follow directly. */
    return table;
}

/* Returns the entry of texel `i`. The number of entries determines the size of an index [lut-width]; low byte first. */
static const unsigned char *entry_of(const Table *table, const unsigned char *indices, size_t i)
{
    size_t index = table->count <= 256 ? indices[i] : indices[2 * i] + 256 * (size_t)indices[2 * i + 1];

    if (index >= table->count)                              /* [lut-range] */
        fail(MALFORMED, "an index is past the last entry");
    return table->entries + index * table->width;
}

/* 2.7 and 2.8: returns the address of texel `i` in stored order. [rows] The bottom row is stored first. */
static unsigned char *texel_at(const Map *map, size_t i)
{
    size_t x = i % map->width, y = map->height - 1 - i / map->width;

    return map->texels + (y * map->width + x) * (size_t)map->channels;
}

static void allocate_texels(Map *map, size_t count)
{
    map->texels = allocate(count, (size_t)map->channels);
}

/* 2.7.1: three blocks for red, green and blue, each with six coefficients per texel [blocks] */
static void read_rgb(Source *source, Map *map, size_t count)
{
    const unsigned char *blocks = take(source, count, 18);
    size_t i, block;

    allocate_texels(map, count);
    for (i = 0; i < count; i++)
        for (block = 0; block < 3; block++)
            memcpy(texel_at(map, i) + 6 * block, blocks + (block * count + i) * 6, 6);
}

/* 2.7.3: a block with six coefficients per texel, then a block with R, G, B per texel [blocks] */
static void read_lrgb(Source *source, Map *map, size_t count)
{
    const unsigned char *coefficients = take(source, count, 9);
    const unsigned char *colors = coefficients + 6 * count;
    size_t i;

    allocate_texels(map, count);
    for (i = 0; i < count; i++) {
        memcpy(texel_at(map, i), coefficients + 6 * i, 6);
        memcpy(texel_at(map, i) + 6, colors + 3 * i, 3);
    }
}

/* 2.8: all indices. In PTM_LUT, the colors of all texels follow. In PTM_C_LUT, the entries contain the colors. */
static void read_indexed(Source *source, Map *map, size_t count, const Table *table)
{
    const unsigned char *indices = take(source, count, table->count <= 256 ? 1 : 2);
    const unsigned char *colors = table->width == 6 ? take(source, count, 3) : NULL;
    size_t i;

    allocate_texels(map, count);
    for (i = 0; i < count; i++) {
        memcpy(texel_at(map, i), entry_of(table, indices, i), table->width);
        if (colors != NULL)
            memcpy(texel_at(map, i) + 6, colors + 3 * i, 3);
    }
}

/* Reads a file section by section. Trailing bytes are ignored [trailing]. */
static Map read_map(Source *source)
{
    Map map;
    Table table = { 0, 0, NULL };
    Format format;
    size_t count;

    memset(&map, 0, sizeof map);
    read_version(source);                                   /* 2.1 */
    format = read_format(source);                           /* 2.2 */
    read_size(source, &map);                                /* 2.3 */
    read_scale_and_bias(source, &map);                      /* 2.4 */
    if (format == LUT || format == C_LUT)
        table = read_table(source, format);                 /* 2.5 */
    map.channels = format == RGB ? 18 : 9;
    count = map.width * map.height;
    if (format == RGB)                                      /* 2.7 and 2.8 */
        read_rgb(source, &map, count);
    else if (format == LRGB)
        read_lrgb(source, &map, count);
    else
        read_indexed(source, &map, count, &table);
    return map;
}

/* 1.0 Background: the polynomial, and the color under a light */

static double polynomial(const double *a, double lu, double lv)
{
    return a[0] * lu * lu + a[1] * lv * lv + a[2] * lu * lv + a[3] * lu + a[4] * lv + a[5];
}

/* [color] In RGB, each channel is its polynomial; in the other formats, luminance * color / 255. Clamp last, then round. */
static void color_of(const Map *map, const unsigned char *texel, double lu, double lv, unsigned char *color)
{
    double values[18];
    int i;

    for (i = 0; i < map->channels; i++)
        values[i] = final_value(map, texel, i);
    for (i = 0; i < 3; i++) {
        double c = map->channels == 18 ? polynomial(values + 6 * i, lu, lv) : polynomial(values, lu, lv) * values[6 + i] / 255;

        color[i] = (unsigned char)(c >= 255 ? 255 : c > 0 ? c + 0.5 : 0);
    }
}

/* The protocol: one header line, then the samples of each texel, top row first */

static void put(const void *bytes, size_t size)
{
    if (fwrite(bytes, 1, size, stdout) != size)
        fail(1, "standard output cannot be written");
}

/* Writes a float as four bytes, low byte first on any machine. */
static void put_float(double value)
{
    float narrow = (float)value;
    unsigned char bytes[4];
    uint32_t bits;
    int i;

    memcpy(&bits, &narrow, sizeof bits);
    for (i = 0; i < 4; i++)
        bytes[i] = (unsigned char)(bits >> 8 * i & 255);
    put(bytes, sizeof bytes);
}

static void print_frame(const Map *map, const char *view, double lu, double lv)
{
    size_t i, count = map->width * map->height;
    int is_rgb = view[0] == 'r' && view[1] == 'g', is_raw = strcmp(view, "raw") == 0, channel;
    char line[128];

    sprintf(line, "PTM1 %s %lu %lu %d %s\n", is_rgb ? "rgb" : view, (unsigned long)map->width, (unsigned long)map->height,
            is_rgb ? 3 : map->channels, is_rgb || is_raw ? "u8" : "f32");
    put(line, strlen(line));
    if (is_raw)
        put(map->texels, count * (size_t)map->channels);
    for (i = 0; i < count && !is_raw; i++) {
        const unsigned char *texel = map->texels + i * (size_t)map->channels;
        unsigned char color[3];

        if (is_rgb) {
            color_of(map, texel, lu, lv, color);
            put(color, sizeof color);
        } else
            for (channel = 0; channel < map->channels; channel++)
                put_float(final_value(map, texel, channel));
    }
    if (fflush(stdout) != 0)
        fail(1, "standard output cannot be written");
}

static const char *const CAPABILITIES =
    "protocol: 1\n"
    "name: ptm-decoder-c\n"
    "version: \"1.0\"\n"
    "views: [raw, coef, rgb]\n"
    "formats: [PTM_FORMAT_RGB, PTM_FORMAT_LRGB, PTM_FORMAT_PTM_LUT, PTM_FORMAT_PTM_C_LUT]\n"
    "modes: [one-shot]\n"
    "reject_exit: 65\n";

/* Parses the view, and the light of "rgb:LU,LV". Other views are unsupported. */
static void read_view(const char *view, double *lu, double *lv)
{
    char light[128], *comma;

    if (strcmp(view, "raw") == 0 || strcmp(view, "coef") == 0)
        return;
    if (strncmp(view, "rgb:", 4) != 0 || strlen(view) >= sizeof light)
        fail(UNSUPPORTED, "view");
    strcpy(light, view + 4);
    comma = strchr(light, ',');
    if (comma == NULL)
        fail(UNSUPPORTED, "view");
    *comma = '\0';
    if (!is_number(light) || !is_number(comma + 1))
        fail(UNSUPPORTED, "view");
    *lu = strtod(light, NULL);
    *lv = strtod(comma + 1, NULL);
}

/* Reads the whole file into a buffer that grows as needed. */
static Source read_file(const char *path)
{
    FILE *file = fopen(path, "rb");
    size_t room = 65536, size = 0, got;
    unsigned char *bytes;
    Source source;

    if (file == NULL)
        fail(1, strerror(errno));
    bytes = allocate(room, 1);
    while ((got = fread(bytes + size, 1, room - size, file)) > 0) {
        size += got;
        if (size == room) {
            unsigned char *more = room > SIZE_MAX / 2 ? NULL : realloc(bytes, room *= 2);
            if (more == NULL)
                fail(1, "not enough memory");
            bytes = more;
        }
    }
    if (ferror(file))
        fail(1, strerror(errno));
    fclose(file);
    source.bytes = bytes;
    source.size = size;
    source.at = 0;
    return source;
}

int main(int argc, char **argv)
{
    double lu = 0, lv = 0;
    Source source;
    Map map;

#if defined(_WIN32)
    _setmode(_fileno(stdout), _O_BINARY);       /* Text mode would write CR LF for LF bytes in the samples. */
#endif
    if (argc == 2 && strcmp(argv[1], "capabilities") == 0) {
        fputs(CAPABILITIES, stdout);
        return 0;
    }
    if (argc != 3) {
        fputs("usage: ptm_decoder VIEW FILE\n", stderr);
        return 64;
    }
    read_view(argv[1], &lu, &lv);
    source = read_file(argv[2]);
    map = read_map(&source);
    print_frame(&map, argv[1], lu, lv);
    free(map.texels);
    free((void *)source.bytes);
    return 0;
}
