/* Runs a fuzz target without a fuzzer: every file of a corpus, cut at every byte.
 * replay FOLDER. Exits 1 if the folder holds nothing; the target aborts on a broken promise. */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static int replay(const char *path)
{
    static uint8_t data[1 << 16];
    FILE *file = fopen(path, "rb");
    if (!file)
        return 0;
    size_t size = fread(data, 1, sizeof data, file);
    fclose(file);
    for (size_t cut = 0; cut <= size; cut++) {
        /* A block of its own, so that a sanitizer sees reads past its end. */
        uint8_t *copy = malloc(cut ? cut : 1);
        if (!copy)
            return 0;
        memcpy(copy, data, cut);
        LLVMFuzzerTestOneInput(copy, cut);
        free(copy);
    }
    return 1;
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
