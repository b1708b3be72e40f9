/* Runs a fuzz target without a fuzzer: every file of a corpus, cut at every byte, and a
 * thousand damaged copies of it, the same ones each time. replay FOLDER. Exits 1 if the folder
 * holds nothing; the target aborts on a broken promise. */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { SIZE_MAX_READ = 1 << 16, DAMAGED = 1000 };

/* xorshift64 (Marsaglia, "Xorshift RNGs", J. Stat. Software 8(14), 2003). */
static uint64_t next(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

/* A block of its own, so that a sanitizer sees reads past its end. */
static int run(const uint8_t *data, size_t size)
{
    uint8_t *copy = malloc(size ? size : 1);
    if (!copy)
        return 0;
    memcpy(copy, data, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
    return 1;
}

/* Puts other bytes in a few places, or moves a stretch to another place. */
static void damage(uint8_t *data, size_t size, uint64_t *state)
{
    static const char likely[] = "0919-.e \n!|;()[]{}\"'\0\x7f\xff";
    for (uint64_t i = next(state) % 6; i > 0; i--)
        data[next(state) % size] = next(state) & 1
                                       ? (uint8_t)likely[next(state) % (sizeof likely - 1)]
                                       : (uint8_t)next(state);
    if (next(state) % 4 == 0) {
        size_t from = next(state) % size, to = next(state) % size;
        size_t most = size - (from > to ? from : to);
        memmove(data + to, data + from, next(state) % (most + 1));
    }
}

static int replay(const char *path)
{
    static uint8_t data[SIZE_MAX_READ], copy[SIZE_MAX_READ];
    uint64_t state = 1;
    FILE *file = fopen(path, "rb");
    if (!file)
        return 0;
    size_t size = fread(data, 1, sizeof data, file);
    fclose(file);
    int ran = 1;
    for (size_t cut = 0; ran && cut <= size; cut++)
        ran = run(data, cut);
    for (int i = 0; ran && size && i < DAMAGED; i++) {
        memcpy(copy, data, size);
        damage(copy, size, &state);
        ran = run(copy, size);
    }
    return ran;
}

int main(int argc, char **argv)
{
    DIR *dir = argc == 2 ? opendir(argv[1]) : NULL;
    int files = 0, read = 0;
    for (struct dirent *entry; dir && (entry = readdir(dir));) {
        char path[1024];
        if (entry->d_name[0] == '.')
            continue;
        snprintf(path, sizeof path, "%s/%s", argv[1], entry->d_name);
        files++;
        read += replay(path);
    }
    if (dir)
        closedir(dir);
    printf("%d inputs replayed\n", read);
    return files == 0 || read < files;
}
