#include "option_words.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "photons/bias.h"

/* Photon maps and how they are looked up. */

static pm_map_kind kind_of(const char *option)
{
    switch (option[3]) {
    case 'c':
        return PM_MAP_CAUSTIC;
    case 'v':
        return PM_MAP_VOLUME;
    case 'd':
        return PM_MAP_DIRECT;
    default:
        return PM_MAP_GLOBAL;
    }
}

/* A gather count may follow; and a second one, which asks for bias compensation. */
static pm_status take_gather(struct pm_words *words, uint32_t *least, uint32_t *most)
{
    if (!pm_word_is_count(words))
        return PM_OK;
    pm_status st = pm_word_u32(words, "photons an estimate", 1, PM_GATHER_MAX, least);
    if (!st && pm_word_is_count(words))
        st =
            pm_word_u32(words, "the most photons an estimate", *least + 1, PM_GATHER_MAX, most);
    return st;
}

/* -apcb: both are asked for. */
static pm_status require_range(const struct pm_words *words, const pm_map_option *map)
{
    if (words->option[4] != 'b' || map->gather_max)
        return PM_OK;
    return pm_error_set(
        words->err, PM_E_MISSING,
        "%s: the fewest and the most photons an estimate are missing behind the "
        "file, e.g. 50 500",
        words->option);
}

/* A precomputed map stands in for the global one, and a second of a kind for none. */
static pm_status check_alone(const struct pm_words *words, const pm_map_option *map,
                             bool precomputed)
{
    if (!map->given)
        return PM_OK;
    if (map->precomputed == precomputed)
        return pm_error_set(words->err, PM_E_RANGE,
                            "%s: is given twice; give one map of a kind", words->option);
    return pm_error_set(words->err, PM_E_RANGE,
                        "%s: a precomputed map stands in for the global one; give one of -apg "
                        "and -app",
                        words->option);
}

/* -app N BW | mkpmap -app FILE N BW | rpict -app FILE [1] */
pm_status pm_take_precomputed(struct pm_words *words)
{
    pm_verb verb = words->out->verb;
    pm_map_option *map = &words->out->maps[PM_MAP_GLOBAL];
    pm_status st = check_alone(words, map, true);
    if (st)
        return st;
    *map = (pm_map_option){.given = true, .precomputed = true};
    if (!(verb & RENDERING))
        st = pm_word_text(words, "a file", &map->file);
    if (st || verb & (PM_VERB_RPICT | PM_VERB_RTRACE)) {
        uint32_t one;
        return st || !pm_word_is_count(words)
                   ? st
                   : pm_word_u32(words,
                                 "1 or nothing, as the closest photon alone is looked up", 1, 1,
                                 &one);
    }
    st = pm_word_count(words, "a number of photons", 1, 1000000000, &map->count);
    if (!st)
        st = pm_word_u32(words, "photons that irradiance is precomputed from", 1,
                         map->count < PM_GATHER_MAX ? (uint32_t)map->count : PM_GATHER_MAX,
                         &map->gather);
    return st;
}

pm_status pm_take_fraction(struct pm_words *words)
{
    double *fraction = &words->out->fraction;
    pm_status st = pm_word_number(words, "a fraction", fraction);
    if (!st && !(*fraction >= 1e-9 && *fraction <= 1))
        st = pm_word_bad(words, words->argv[words->at - 1], "greater than 0, at most 1");
    return st;
}

/* -apg N [K [K2]] | mkpmap -apg FILE N | rpict -apg FILE [K [K2]] | rpict -apgb FILE K K2 */
pm_status pm_take_map(struct pm_words *words)
{
    pm_verb verb = words->out->verb;
    pm_map_option *map = &words->out->maps[kind_of(words->option)];
    pm_status st = check_alone(words, map, false);
    if (st)
        return st;
    *map = (pm_map_option){.given = true};
    if (!(verb & RENDERING))
        st = pm_word_text(words, "a file", &map->file);
    if (!st && (verb & (RENDERING | PM_VERB_MKPMAP)))
        st = pm_word_count(words, "a number of photons", 1, 1000000000, &map->count);
    if (!st && verb != PM_VERB_MKPMAP)
        st = take_gather(words, &map->gather, &map->gather_max);
    return st ? st : require_range(words, map);
}

pm_status pm_take_detected_map(struct pm_words *words)
{
    pm_options *out = words->out;
    if (out->detected_count == PM_MAP_KINDS)
        return pm_error_set(words->err, PM_E_RANGE, "-ap: at most a map of each kind");
    pm_map_option *map = &out->detected[out->detected_count++];
    map->given = true;
    pm_status st = pm_word_text(words, "a file", &map->file);
    return st ? st : take_gather(words, &map->gather, &map->gather_max);
}

pm_status pm_take_bandwidth(struct pm_words *words)
{
    const char *text = NULL;
    pm_status st = pm_word_text(words, "bias or chi2", &text);
    if (st)
        return st;
    for (int b = 0; b < PM_BANDWIDTHS; b++)
        if (!strcmp(text, pm_bandwidth_name((pm_bandwidth)b)))
            words->out->bandwidth = text;
    return words->out->bandwidth ? PM_OK : pm_word_bad(words, text, "bias or chi2");
}

pm_status pm_take_bounces(struct pm_words *words)
{
    double value;
    pm_status st = pm_word_number(words, "a whole number", &value);
    if (st)
        return st;
    if (value != floor(value) || fabs(value) > 100)
        return pm_word_bad(words, words->argv[words->at - 1],
                           "a whole number from -100 to 100");
    words->out->ambient_bounces = (int)value;
    return PM_OK;
}

pm_status pm_take_sequence(struct pm_words *words)
{
    return pm_word_u32(words, "passes", 1, PM_PASSES_MAX, &words->out->sequence);
}

pm_status pm_take_pass(struct pm_words *words)
{
    words->out->one_pass = true;
    return pm_word_u32(words, "a pass, counted from 0", 0, PM_PASSES_MAX - 1,
                       &words->out->pass);
}
