#include "scene/names.h"

#include <string.h>

/* A leaf holds a name; an inner node the highest bit in which its two halves differ. A name
 * ends in zeros without end, which no other name has: a word holds no zero byte. */
struct pm_name_node {
    struct pm_name_node *child[2]; /* both NULL in a leaf */
    const char *name;
    size_t length; /* of the name; in an inner node the byte that holds the bit */
    int32_t index;
    uint8_t bit; /* mask of one bit */
};

static uint8_t byte_at(const char *text, size_t length, size_t i)
{
    return i < length ? (uint8_t)text[i] : 0;
}

static int side(const struct pm_name_node *inner, const pm_word *word)
{
    return (byte_at(word->text, word->length, inner->length) & inner->bit) != 0;
}

static bool is_leaf(const struct pm_name_node *node)
{
    return !node->child[0];
}

static bool is_named(const struct pm_name_node *leaf, const pm_word *word)
{
    return leaf->length == word->length && memcmp(leaf->name, word->text, word->length) == 0;
}

/* The only leaf that can be the word's. */
static struct pm_name_node *candidate(const pm_names *names, const pm_word *word)
{
    struct pm_name_node *node = names->root;
    while (node && !is_leaf(node))
        node = node->child[side(node, word)];
    return node;
}

int32_t pm_names_find(pm_names *names, const pm_word *word)
{
    if (names->last && is_named(names->last, word))
        return names->last->index;
    struct pm_name_node *leaf = candidate(names, word);
    if (!leaf || !is_named(leaf, word))
        return -1;
    names->last = leaf;
    return leaf->index;
}

const char *pm_names_text(pm_names *names, const pm_word *word)
{
    return pm_names_find(names, word) < 0 ? "void" : names->last->name;
}

static struct pm_name_node *new_leaf(pm_names *names, const pm_word *word, int32_t index)
{
    struct pm_name_node *leaf = pm_arena_alloc(names->arena, sizeof *leaf);
    if (!leaf)
        return NULL;
    leaf->name = pm_arena_text(names->arena, word->text, word->length);
    leaf->length = word->length;
    leaf->index = index;
    return leaf->name ? leaf : NULL;
}

/* True if `node` tests a bit that comes before bit `mask` of byte `at`. */
static bool comes_before(const struct pm_name_node *node, size_t at, uint8_t mask)
{
    return !is_leaf(node) && (node->length < at || (node->length == at && node->bit > mask));
}

pm_status pm_names_set(pm_names *names, const pm_word *word, int32_t index)
{
    struct pm_name_node *near = candidate(names, word);
    if (near && is_named(near, word)) {
        near->index = index;
        return PM_OK;
    }
    struct pm_name_node *leaf = new_leaf(names, word, index);
    struct pm_name_node *inner = pm_arena_alloc(names->arena, sizeof *inner);
    if (!leaf || !inner)
        return PM_E_MEMORY;
    if (!near) {
        names->root = leaf;
        return PM_OK;
    }
    size_t at = 0;
    while (byte_at(near->name, near->length, at) == byte_at(word->text, word->length, at))
        at++;
    unsigned difference =
        byte_at(near->name, near->length, at) ^ byte_at(word->text, word->length, at);
    uint8_t mask = 0x80;
    while (!(difference & mask))
        mask = (uint8_t)(mask >> 1);
    struct pm_name_node **link = &names->root;
    while (comes_before(*link, at, mask))
        link = &(*link)->child[side(*link, word)];
    *inner = (struct pm_name_node){.length = at, .bit = mask};
    inner->child[side(inner, word)] = leaf;
    inner->child[!side(inner, word)] = *link;
    *link = inner;
    return PM_OK;
}
