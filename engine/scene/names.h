#ifndef PM_SCENE_NAMES_H
#define PM_SCENE_NAMES_H

#include "base/arena.h"
#include "scene/lexer.h"

/* What each modifier's name means at the current line: a crit-bit tree (Bernstein), whose
 * look-ups take at most the word's length, so no choice of names can make a scene slow to read.
 * Zero-initialised storage with an arena is empty. */
typedef struct pm_names {
    pm_arena *arena;
    struct pm_name_node *root;
    struct pm_name_node *last; /* leaf found last: neighbours tend to share their material */
} pm_names;

/* The index that the word means, or -1. */
int32_t pm_names_find(pm_names *names, const pm_word *word);

/* The word's text, which lasts as long as the arena and is one pointer for equal words; "void"
 * for words without a meaning. */
const char *pm_names_text(pm_names *names, const pm_word *word);

/* Makes the word mean `index` (>= 0) from now on. PM_E_MEMORY. */
PM_MUST_USE pm_status pm_names_set(pm_names *names, const pm_word *word, int32_t index);

#endif
