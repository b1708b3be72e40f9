#include "cmocka_first.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "store.h"

enum { MIB = 1 << 20 };

/* A folder of its own for each test. */
struct place {
    char folder[64], path[96];
};

static int make_place(void **state)
{
    struct place *place = calloc(1, sizeof *place);
    strcpy(place->folder, "/tmp/pm-store-XXXXXX");
    if (!place || !mkdtemp(place->folder))
        return -1;
    snprintf(place->path, sizeof place->path, "%s/s.sqlite", place->folder);
    *state = place;
    return 0;
}

static int remove_place(void **state)
{
    static const char *const ends[] = {"", "-wal", "-shm", ".pid"};
    struct place *place = *state;
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
        char path[128];
        snprintf(path, sizeof path, "%s%s", place->path, ends[i]);
        unlink(path);
    }
    int failed = rmdir(place->folder);
    free(place);
    return failed;
}

static pm_store *open_limited(const struct place *place, uint64_t limit)
{
    pm_store *store = NULL;
    const pm_store_options options = {.path = place->path, .limit_bytes = limit};
    assert_int_equal(pm_store_open(&options, &store, NULL), PM_OK);
    return store;
}

static pm_store *open_store(const struct place *place)
{
    return open_limited(place, 0);
}

/* Bytes that no compression and no other seed gives. */
static unsigned char *noise(size_t size, uint32_t seed)
{
    unsigned char *bytes = malloc(size ? size : 1);
    uint32_t x = seed * 2654435761U + 1;
    for (size_t i = 0; i < size; i++) {
        x = x * 1664525U + 1013904223U;
        bytes[i] = (unsigned char)(x >> 24);
    }
    return bytes;
}

static pm_blob put(pm_store *store, const void *data, size_t size)
{
    pm_blob blob;
    bool existed;
    assert_int_equal(pm_store_blob_put(store, data, size, &blob, &existed, NULL), PM_OK);
    return blob;
}

static pm_status read_all(pm_store *store, const pm_blob *blob, unsigned char *out)
{
    for (uint64_t at = 0; at < blob->size; at += PM_CHUNK_BYTES) {
        size_t size = 0;
        pm_status st =
            pm_store_blob_chunk(store, blob, at / PM_CHUNK_BYTES, out + at, &size, NULL);
        if (st)
            return st;
    }
    return PM_OK;
}

static int64_t add_job(pm_store *store, const char *request)
{
    int64_t id = 0;
    const pm_new_job job = {.request = request};
    assert_int_equal(pm_store_job_add(store, &job, &id, NULL), PM_OK);
    return id;
}

static void assert_state(pm_store *store, int64_t id, const char *expected)
{
    pm_json *job = NULL;
    assert_int_equal(pm_store_job_get(store, id, &job, NULL), PM_OK);
    assert_string_equal(pm_json_get_text(job, "state", "?"), expected);
    pm_json_free(job);
}

/* ---- blobs ---- */

static void blobs_of_every_size_come_back_whole(void **state)
{
    static const size_t sizes[] = {0, 1, MIB - 1, MIB, MIB + 1, 3 * MIB + 17};
    pm_store *store = open_store(*state);
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        unsigned char *data = noise(sizes[i], (uint32_t)i), *back = malloc(sizes[i] + 1);
        pm_blob blob = put(store, data, sizes[i]), found;
        pm_digest digest = pm_digest_of(data, sizes[i]);
        assert_int_equal(pm_store_blob_find(store, &digest, &found, NULL), PM_OK);
        assert_int_equal(found.id, blob.id);
        assert_int_equal(found.size, sizes[i]);
        assert_int_equal(read_all(store, &found, back), PM_OK);
        assert_memory_equal(back, data, sizes[i]);
        free(data);
        free(back);
    }
    pm_store_close(store);
}

static void an_upload_and_bytes_at_once_are_the_same_blob(void **state)
{
    pm_store *store = open_store(*state);
    unsigned char *data = noise(MIB + 5, 1);
    int64_t upload;
    bool existed = true;
    pm_digest digest = pm_digest_of(data, MIB + 5);
    assert_int_equal(pm_store_upload_begin(store, &upload, NULL), PM_OK);
    assert_int_equal(pm_store_upload_chunk(store, upload, 0, data, MIB, NULL), PM_OK);
    pm_blob blob;
    assert_int_equal(pm_store_blob_find(store, &digest, &blob, NULL), PM_E_MISSING);
    assert_int_equal(pm_store_upload_chunk(store, upload, 1, data + MIB, 5, NULL), PM_OK);
    assert_int_equal(pm_store_upload_finish(store, upload, &digest, MIB + 5, &existed, NULL),
                     PM_OK);
    assert_false(existed);
    assert_int_equal(pm_store_blob_put(store, data, MIB + 5, &blob, &existed, NULL), PM_OK);
    assert_true(existed);
    assert_int_equal(blob.id, upload);
    free(data);
    pm_store_close(store);
}

static void an_upload_cut_short_leaves_nothing(void **state)
{
    pm_store *store = open_store(*state);
    uint64_t before = pm_store_bytes(store);
    unsigned char *data = noise(MIB, 2);
    int64_t upload;
    assert_int_equal(pm_store_upload_begin(store, &upload, NULL), PM_OK);
    assert_int_equal(pm_store_upload_chunk(store, upload, 0, data, MIB, NULL), PM_OK);
    assert_true(pm_store_bytes(store) > before + MIB / 2);
    pm_store_close(store); /* as if the client, or the server, had gone */
    store = open_store(*state);
    assert_int_equal(pm_store_bytes(store), before);
    assert_int_equal(pm_store_upload_begin(store, &upload, NULL), PM_OK);
    assert_int_equal(pm_store_upload_chunk(store, upload, 0, data, MIB, NULL), PM_OK);
    pm_store_upload_abandon(store, upload);
    assert_int_equal(pm_store_bytes(store), before);
    free(data);
    pm_store_close(store);
}

/* Flips one bit of `needle` in the database file. */
static void flip_bit(const char *path, const unsigned char *needle, size_t size)
{
    int file = open(path, O_RDWR);
    off_t end = lseek(file, 0, SEEK_END);
    unsigned char *all = malloc((size_t)end);
    assert_int_equal(pread(file, all, (size_t)end, 0), end);
    unsigned char *at = memmem(all, (size_t)end, needle, size);
    assert_non_null(at);
    *at ^= 1;
    assert_int_equal(pwrite(file, at, 1, at - all), 1);
    free(all);
    close(file);
}

static void a_flipped_bit_is_found_and_the_blob_can_be_made_again(void **state)
{
    const struct place *place = *state;
    unsigned char *data = noise(2 * MIB, 3), *back = malloc(2 * MIB);
    pm_store *store = open_store(place);
    pm_blob blob = put(store, data, 2 * MIB);
    pm_store_close(store); /* the last one to close writes the log back into the file */
    flip_bit(place->path, data + MIB + 1000, 32);
    store = open_store(place);
    size_t size;
    assert_int_equal(pm_store_blob_chunk(store, &blob, 0, back, &size, NULL), PM_OK);
    assert_int_equal(pm_store_blob_chunk(store, &blob, 1, back, &size, NULL), PM_E_CORRUPT);
    pm_store_blob_drop(store, &blob);
    assert_int_equal(pm_store_blob_find(store, &blob.digest, &blob, NULL), PM_E_MISSING);
    blob = put(store, data, 2 * MIB);
    assert_int_equal(read_all(store, &blob, back), PM_OK);
    assert_memory_equal(back, data, 2 * MIB);
    free(data);
    free(back);
    pm_store_close(store);
}

static void upload(pm_store *store, const unsigned char *data, uint64_t chunks, bool *existed)
{
    int64_t id = 0;
    const pm_digest digest = pm_digest_of(data, chunks * MIB);
    assert_int_equal(pm_store_upload_begin(store, &id, NULL), PM_OK);
    for (uint64_t n = 0; n < chunks; n++)
        assert_int_equal(pm_store_upload_chunk(store, id, n, data + n * MIB, MIB, NULL), PM_OK);
    assert_int_equal(pm_store_upload_finish(store, id, &digest, chunks * MIB, existed, NULL),
                     PM_OK);
}

/* Whoever refers to the blob by its id, such as a scene, has it back. */
static void bytes_that_come_again_heal_a_damaged_blob(void **state)
{
    const struct place *place = *state;
    unsigned char *data = noise(2 * MIB, 4), *back = malloc(2 * MIB);
    pm_store *store = open_store(place);
    const pm_blob first = put(store, data, 2 * MIB);
    for (int by_upload = 0; by_upload < 2; by_upload++) {
        pm_blob again = first;
        bool existed = true;
        pm_store_close(store);
        flip_bit(place->path, data + MIB + 1000, 32);
        store = open_store(place);
        assert_int_equal(read_all(store, &first, back), PM_E_CORRUPT);
        if (by_upload)
            upload(store, data, 2, &existed);
        else
            assert_int_equal(pm_store_blob_put(store, data, 2 * MIB, &again, &existed, NULL),
                             PM_OK);
        assert_false(existed);
        assert_int_equal(again.id, first.id);
        assert_int_equal(read_all(store, &first, back), PM_OK);
        assert_memory_equal(back, data, 2 * MIB);
        upload(store, data, 2, &existed);
        assert_true(existed);
    }
    free(data);
    free(back);
    pm_store_close(store);
}

/* ---- batches ---- */

static void batches_are_found_by_family_and_index(void **state)
{
    pm_store *store = open_store(*state);
    pm_digest family = pm_digest_of("family", 6), other = pm_digest_of("other", 5);
    const pm_stored_batch batches[] = {
        {family, 0, "zero", 4}, {family, 7, "seven", 5}, {other, 0, "zero", 4}};
    assert_int_equal(pm_store_batches_put(store, batches, 3, NULL), PM_OK);
    assert_int_equal(pm_store_batches_put(store, batches, 3, NULL), PM_OK);
    assert_int_equal(pm_store_batch_count(store), 3);
    pm_blob blob;
    char text[PM_CHUNK_BYTES];
    size_t size;
    assert_int_equal(pm_store_batch_find(store, &family, 7, &blob, NULL), PM_OK);
    assert_int_equal(pm_store_blob_chunk(store, &blob, 0, text, &size, NULL), PM_OK);
    assert_memory_equal(text, "seven", 5);
    assert_int_equal(pm_store_batch_find(store, &family, 1, &blob, NULL), PM_E_MISSING);
    assert_int_equal(pm_store_batch_find(store, &other, 7, &blob, NULL), PM_E_MISSING);
    pm_store_close(store);
}

/* ---- eviction ---- */

static void eviction_takes_old_batches_and_leaves_scenes_and_inputs(void **state)
{
    pm_store *store = open_limited(*state, 8 * MIB);
    unsigned char *bundle = noise(MIB, 100), *input = noise(MIB, 101);
    pm_blob bundle_blob = put(store, bundle, MIB), input_blob = put(store, input, MIB), found;
    const pm_scene_record scene = {.id = pm_digest_of("id", 2),
                                   .hash = pm_digest_of("hash", 4),
                                   .bundle = bundle_blob.digest,
                                   .main_name = (char *)"a.rad",
                                   .info = pm_json_pack("{}")};
    assert_int_equal(pm_store_scene_put(store, &scene, NULL), PM_OK);
    int64_t id;
    const pm_new_job job = {.request = "{}", .inputs = &input_blob.digest, .input_count = 1};
    assert_int_equal(pm_store_job_add(store, &job, &id, NULL), PM_OK);
    pm_digest family = pm_digest_of("f", 1);
    for (uint32_t i = 0; i < 20; i++) {
        unsigned char *data = noise(MIB, i);
        const pm_stored_batch batch = {family, i, data, MIB};
        assert_int_equal(pm_store_batches_put(store, &batch, 1, NULL), PM_OK);
        assert_true(pm_store_bytes(store) <= 8 * MIB);
        free(data);
    }
    assert_true(pm_store_evicted(store) >= 14);
    assert_int_equal(pm_store_batch_find(store, &family, 0, &found, NULL), PM_E_MISSING);
    assert_int_equal(pm_store_batch_find(store, &family, 19, &found, NULL), PM_OK);
    assert_int_equal(pm_store_blob_find(store, &bundle_blob.digest, &found, NULL), PM_OK);
    assert_int_equal(pm_store_blob_find(store, &input_blob.digest, &found, NULL), PM_OK);
    pm_json_free(scene.info);
    free(bundle);
    free(input);
    pm_store_close(store);
}

/* ---- jobs ---- */

static void a_job_goes_from_queue_to_results(void **state)
{
    pm_store *store = open_store(*state);
    int64_t id = add_job(store, "{\"kind\":\"render\",\"scene\":\"abc\"}");
    assert_state(store, id, "queued");
    assert_int_equal(pm_store_job_start(store, id, NULL), PM_OK);
    assert_state(store, id, "running");
    const pm_new_result results[] = {{"picture.exr", "exr", NULL, "EXR", 3},
                                     {"picture.png", "png", NULL, "PNG!", 4}};
    pm_json *answer = pm_json_pack("{s:i}", "passes", 3);
    const pm_job_end end = {
        .state = "done", .answer = answer, .results = results, .result_count = 2};
    assert_int_equal(pm_store_job_finish(store, id, &end, NULL), PM_OK);
    pm_json *job = NULL;
    assert_int_equal(pm_store_job_get(store, id, &job, NULL), PM_OK);
    assert_string_equal(pm_json_get_text(job, "kind", ""), "render");
    assert_int_equal(pm_json_get_integer(pm_json_get(job, "answer"), "passes", 0), 3);
    const pm_json *list = pm_json_get(job, "result");
    assert_int_equal(pm_json_length(list), 2);
    assert_string_equal(pm_json_get_text(pm_json_at(list, 1), "name", ""), "picture.png");
    pm_blob blob;
    bool evicted = true;
    char format[16];
    assert_int_equal(
        pm_store_result_find(store, id, NULL, "png", &blob, &evicted, format, NULL), PM_OK);
    assert_int_equal(blob.size, 4);
    assert_false(evicted);
    assert_int_equal(pm_store_result_find(store, id, NULL, NULL, &blob, &evicted, format, NULL),
                     PM_OK);
    assert_string_equal(format, "exr");
    assert_int_equal(pm_store_result_find(store, id, "x", NULL, &blob, &evicted, format, NULL),
                     PM_E_MISSING);
    pm_json_free(job);
    pm_json_free(answer);
    pm_store_close(store);
}

static void running_jobs_are_queued_again_but_not_for_ever(void **state)
{
    pm_store *store = open_store(*state);
    int64_t id = add_job(store, "{\"kind\":\"map\"}"), done = add_job(store, "{}");
    const pm_job_end end = {.state = "cancelled"};
    assert_int_equal(pm_store_job_finish(store, done, &end, NULL), PM_OK);
    for (int i = 0; i < PM_JOB_ATTEMPTS; i++) {
        int64_t *ids = NULL;
        size_t count = 0;
        assert_int_equal(pm_store_job_recover(store, &ids, &count, NULL), PM_OK);
        assert_int_equal(count, 1);
        assert_int_equal(ids[0], id);
        free(ids);
        assert_int_equal(pm_store_job_start(store, id, NULL), PM_OK);
    }
    int64_t *ids = NULL;
    size_t count = 9;
    assert_int_equal(pm_store_job_recover(store, &ids, &count, NULL), PM_OK);
    assert_int_equal(count, 0);
    free(ids);
    assert_state(store, id, "failed");
    pm_json *job = NULL;
    assert_int_equal(pm_store_job_get(store, id, &job, NULL), PM_OK);
    assert_non_null(
        strstr(pm_json_get_text(pm_json_get(job, "problem"), "detail", ""), "three"));
    pm_json_free(job);
    pm_store_close(store);
}

static void a_server_that_stops_in_order_takes_its_attempt_back(void **state)
{
    pm_store *store = open_store(*state);
    int64_t id = add_job(store, "{}");
    for (int i = 0; i < 2 * PM_JOB_ATTEMPTS; i++) {
        assert_int_equal(pm_store_job_start(store, id, NULL), PM_OK);
        assert_int_equal(pm_store_job_requeue(store, id, NULL), PM_OK);
        assert_state(store, id, "queued");
    }
    pm_store_close(store);
}

static void an_idempotency_key_finds_its_job(void **state)
{
    pm_store *store = open_store(*state);
    int64_t id = 0, found = 0;
    char *request = NULL;
    const pm_new_job job = {.request = "{\"a\":1}", .idempotency_key = "k"};
    assert_int_equal(pm_store_job_by_key(store, "k", &found, &request, NULL), PM_E_MISSING);
    assert_int_equal(pm_store_job_add(store, &job, &id, NULL), PM_OK);
    assert_int_equal(pm_store_job_by_key(store, "k", &found, &request, NULL), PM_OK);
    assert_int_equal(found, id);
    assert_string_equal(request, "{\"a\":1}");
    free(request);
    pm_store_close(store);
}

/* ---- the file ---- */

static void one_store_has_one_server(void **state)
{
    const struct place *place = *state;
    pm_store *store = open_store(place), *second = NULL;
    const pm_store_options options = {.path = place->path};
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_store_open(&options, &second, &err), PM_E_MISMATCH);
    char self[32];
    snprintf(self, sizeof self, "%ld", (long)getpid());
    assert_non_null(strstr(err.text, self));
    struct place linked;
    snprintf(linked.path, sizeof linked.path, "%.60s/link", place->folder);
    assert_int_equal(symlink(place->path, linked.path), 0);
    const pm_store_options by_link = {.path = linked.path};
    assert_int_equal(pm_store_open(&by_link, &second, NULL), PM_E_MISMATCH);
    pm_store_close(store);
    store = open_store(&linked);
    pm_store_close(store);
    unlink(linked.path);
}

static void set_integer(const char *path, long at, uint32_t value)
{
    int file = open(path, O_RDWR);
    unsigned char bytes[4] = {(unsigned char)(value >> 24), (unsigned char)(value >> 16),
                              (unsigned char)(value >> 8), (unsigned char)value};
    assert_int_equal(pwrite(file, bytes, 4, at), 4);
    close(file);
}

/* Offsets 60 and 68 of SQLite's header hold user_version and application_id
 * (sqlite.org/fileformat2). */
static void stores_of_newer_servers_and_other_programs_are_refused(void **state)
{
    const struct place *place = *state;
    const pm_store_options options = {.path = place->path};
    pm_store *store = open_store(place);
    pm_store_close(store);
    set_integer(place->path, 60, 2);
    assert_int_equal(pm_store_open(&options, &store, NULL), PM_E_UNSUPPORTED);
    set_integer(place->path, 60, 1);
    set_integer(place->path, 68, 77);
    assert_int_equal(pm_store_open(&options, &store, NULL), PM_E_SYNTAX);
    int file = open(place->path, O_WRONLY | O_TRUNC);
    assert_int_equal(write(file, "this is a text and no database at all", 37), 37);
    close(file);
    assert_int_equal(pm_store_open(&options, &store, NULL), PM_E_SYNTAX);
}

/* A limit on file sizes stands for a full disk: the kernel refuses the write (EFBIG for
 * ENOSPC). */
static void a_full_disk_is_an_error_and_loses_nothing(void **state)
{
    const struct place *place = *state;
    pm_store *store = open_store(place);
    unsigned char *data = noise(8 * MIB, 5), *back = malloc(8 * MIB);
    pm_blob small = put(store, data, 1000), blob;
    struct rlimit old, tight = {2 * MIB, 0};
    bool existed;
    getrlimit(RLIMIT_FSIZE, &old);
    tight.rlim_max = old.rlim_max;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &tight), 0);
    pm_error err = PM_ERROR_INIT;
    assert_int_equal(pm_store_blob_put(store, data, 8 * MIB, &blob, &existed, &err), PM_E_IO);
    pm_digest family = pm_digest_of("f", 1);
    const pm_stored_batch batches[] = {{family, 0, "small", 5}, {family, 1, data, 8 * MIB}};
    assert_int_equal(pm_store_batches_put(store, batches, 2, NULL), PM_E_IO);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    assert_true(*err.text);
    assert_int_equal(pm_store_batch_count(store), 0); /* not even the small one */
    pm_digest digest = pm_digest_of(data, 8 * MIB);
    assert_int_equal(pm_store_blob_find(store, &digest, &blob, NULL), PM_E_MISSING);
    assert_int_equal(read_all(store, &small, back), PM_OK);
    assert_memory_equal(back, data, 1000);
    blob = put(store, data, 8 * MIB); /* and goes on once there is room */
    assert_int_equal(read_all(store, &blob, back), PM_OK);
    assert_memory_equal(back, data, 8 * MIB);
    free(data);
    free(back);
    pm_store_close(store);
}

/* A child puts batches and says so after each; killed anywhere, what it said is there, whole.
 */
static void acknowledged_batches_survive_kill_9(void **state)
{
    const struct place *place = *state;
    int said[2];
    pm_digest family = pm_digest_of("f", 1);
    assert_int_equal(pipe(said), 0);
    pid_t child = fork();
    if (!child) {
        pm_store *own = open_store(place);
        for (uint32_t i = 0;; i++) {
            unsigned char *data = noise(MIB / 2, i);
            const pm_stored_batch batch = {family, i, data, MIB / 2};
            if (pm_store_batches_put(own, &batch, 1, NULL) || write(said[1], "x", 1) != 1)
                _exit(1);
            free(data);
        }
    }
    close(said[1]);
    char heard[5];
    for (size_t i = 0; i < sizeof heard; i++)
        assert_int_equal(read(said[0], &heard[i], 1), 1);
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
    uint32_t count = sizeof heard;
    while (read(said[0], heard, 1) == 1)
        count++;
    close(said[0]);
    pm_store *store = open_store(place);
    unsigned char *back = malloc(MIB / 2);
    assert_true(pm_store_batch_count(store) >= count);
    for (uint32_t i = 0; i < pm_store_batch_count(store); i++) {
        unsigned char *data = noise(MIB / 2, i);
        pm_blob blob;
        assert_int_equal(pm_store_batch_find(store, &family, i, &blob, NULL), PM_OK);
        assert_int_equal(read_all(store, &blob, back), PM_OK);
        assert_memory_equal(back, data, MIB / 2);
        free(data);
    }
    free(back);
    pm_store_close(store);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, make_place, remove_place)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(blobs_of_every_size_come_back_whole),
        TEST(an_upload_and_bytes_at_once_are_the_same_blob),
        TEST(an_upload_cut_short_leaves_nothing),
        TEST(a_flipped_bit_is_found_and_the_blob_can_be_made_again),
        TEST(bytes_that_come_again_heal_a_damaged_blob),
        TEST(batches_are_found_by_family_and_index),
        TEST(eviction_takes_old_batches_and_leaves_scenes_and_inputs),
        TEST(a_job_goes_from_queue_to_results),
        TEST(running_jobs_are_queued_again_but_not_for_ever),
        TEST(a_server_that_stops_in_order_takes_its_attempt_back),
        TEST(an_idempotency_key_finds_its_job),
        TEST(one_store_has_one_server),
        TEST(stores_of_newer_servers_and_other_programs_are_refused),
        TEST(a_full_disk_is_an_error_and_loses_nothing),
        TEST(acknowledged_batches_survive_kill_9),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
