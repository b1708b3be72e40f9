#include "language/language_internal.h"

#include <stdlib.h>
#include <string.h>

enum { NAME_SPACE = 2 * PM_LANGUAGE_NAME + 512 };

/* FNV-1a. */
static uint32_t hash_text(const char *text)
{
    uint32_t hash = 2166136261u;
    for (; *text; text++)
        hash = (hash ^ (unsigned char)*text) * 16777619u;
    return hash;
}

/* A name as written, in its context (level 0) or outside of it (level 1), as caldefn.c's
 * qualname has it: a leading mark means this context only, a trailing one the global context.
 * False where there is no such level. */
static bool qualify(const char *mark, const char *name, int level, char out[NAME_SPACE])
{
    bool local = *name == '`';
    if (local)
        name++;
    size_t length = strlen(name);
    bool global = length > 0 && name[length - 1] == '`';
    if (level > 0 && (local || global || !*mark))
        return false;
    if (global)
        length--;
    size_t more = global || level > 0 ? 0 : strlen(mark);
    if (length + more >= NAME_SPACE)
        return false;
    memcpy(out, name, length);
    memcpy(out + length, mark, more);
    out[length + more] = '\0';
    return true;
}

static struct pm_name *find_exactly(const pm_language *language, const char *text)
{
    if (!language->name_size)
        return NULL;
    uint32_t hash = hash_text(text);
    struct pm_name *name = language->names[hash & (language->name_size - 1)];
    while (name && (name->hash != hash || strcmp(name->text, text) != 0))
        name = name->next;
    return name;
}

struct pm_name *pm_name_find(const pm_language *language, const char *mark, const char *name)
{
    char text[NAME_SPACE];
    for (int level = 0; level < 2 && qualify(mark, name, level, text); level++) {
        struct pm_name *found = find_exactly(language, text);
        if (found)
            return found;
    }
    return NULL;
}

static bool grow_table(pm_language *language)
{
    uint32_t size = language->name_size ? 2 * language->name_size : 512;
    struct pm_name **table = calloc(size, sizeof *table);
    if (!table)
        return false;
    for (uint32_t i = 0; i < language->name_size; i++)
        for (struct pm_name *name = language->names[i], *next; name; name = next) {
            next = name->next;
            name->next = table[name->hash & (size - 1)];
            table[name->hash & (size - 1)] = name;
        }
    free(language->names);
    language->names = table;
    language->name_size = size;
    return true;
}

static struct pm_name *insert_exactly(pm_language *language, const char *text)
{
    if (language->name_count >= language->name_size && !grow_table(language))
        return NULL;
    struct pm_name *name = pm_arena_alloc(&language->arena, sizeof *name + strlen(text) + 1);
    if (!name)
        return NULL;
    strcpy(name->text, text);
    name->hash = hash_text(text);
    name->builtin = pm_builtin_find(language->kind, text);
    struct pm_name **head = &language->names[name->hash & (language->name_size - 1)];
    name->next = *head;
    *head = name;
    language->name_count++;
    return name;
}

struct pm_name *pm_name_insert(pm_language *language, const char *mark, const char *name)
{
    char text[NAME_SPACE];
    struct pm_name *found = pm_name_find(language, mark, name);
    if (found)
        return found;
    if (pm_builtin_find(language->kind, name))
        return insert_exactly(language, name);
    return qualify(mark, name, 0, text) ? insert_exactly(language, text) : NULL;
}

struct pm_name *pm_name_define(pm_language *language, const char *mark, const char *name)
{
    char text[NAME_SPACE];
    if (!qualify(mark, name, 0, text))
        return NULL;
    struct pm_name *found = find_exactly(language, text);
    return found ? found : insert_exactly(language, text);
}

int pm_name_length(const char *text)
{
    return (int)strcspn(text, "`");
}
