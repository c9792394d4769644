// Wrong use of the C library, and the codes that it is refused with.
//
//   misuse DIRECTORY
//
// reads the sample of tests/vectors. Prints each expectation that does not hold; exit status 0 if all do.
#include "compass.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 368
#define HEIGHT 360
#define GRAY_BYTES (WIDTH * HEIGHT)
#define EXCLUDED_BYTES ((WIDTH + 7) / 8 * HEIGHT)
// Bytes behind the memory lent that must stay as they are.
#define GUARD 64

static int checked, failed;

static void expect(int line, const char *what, long found, long expected) {
    checked++;
    if (found != expected) {
        failed++;
        printf("line %d: %s is %ld (%s), not %ld\n", line, what, found, compass_status_text((CompassStatus)found),
               expected);
    }
}

#define EXPECT(status, call) expect(__LINE__, #call, (long)(call), (long)COMPASS_STATUS_##status)
#define IS(value, expected) expect(__LINE__, #value, (long)(value), (long)(expected))
#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static uint8_t *site, *gray[2], *excluded[2];
static size_t site_bytes;

static const CompassCamera front = {
    .lens = {.model = COMPASS_LENS_MODEL_KANNALA_BRANDT,
             .fx = 116.0f, .fy = 116.1f, .cx = 182.95f, .cy = 179.9f,
             .parameters.kannala_brandt.k = {0.024f, -0.0105f, -0.0016f, 0.00014f}},
    .width = WIDTH, .height = HEIGHT,
    .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1},
};
static const CompassCamera back = {
    .lens = {.model = COMPASS_LENS_MODEL_KANNALA_BRANDT,
             .fx = 116.25f, .fy = 116.3f, .cx = 183.65f, .cy = 179.2f,
             .parameters.kannala_brandt.k = {0.025f, -0.0107f, -0.00155f, 0.00013f}},
    .width = WIDTH, .height = HEIGHT,
    .rotation = {-0.999975f, 0.005025f, 0.004975f, 0.005f, 0.9999747f, -0.005025f, -0.005f, -0.005f, -0.9999749f},
    .position_m = {0.0012f, -0.0007f, -0.038f},
};
static const CompassPrior prior = {
    .up_kind = COMPASS_UP_KIND_NEAR, .up = {0, 1, 0},
    .height_kind = COMPASS_HEIGHT_KIND_CAMERA, .camera_height_m = 1.6f,
    .place_kind = COMPASS_PLACE_KIND_ANYWHERE,
};

static uint8_t *read_file(const char *directory, const char *name, size_t *length) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *file = fopen(path, "rb");
    if (!file || fseek(file, 0, SEEK_END) != 0) {
        fprintf(stderr, "cannot read %s\n", path);
        exit(2);
    }
    *length = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*length);
    if (!bytes || fread(bytes, 1, *length, file) != *length) {
        exit(2);
    }
    fclose(file);
    return bytes;
}

static CompassFrame frame(int camera) {
    return (CompassFrame){
        .gray = gray[camera], .gray_bytes = GRAY_BYTES,
        .excluded = excluded[camera], .excluded_bytes = EXCLUDED_BYTES,
        .width = WIDTH, .height = HEIGHT,
    };
}

static bool says(const Compass *compass, const char *part) {
    char text[200];
    size_t length = compass_last_error(compass, text, sizeof text);
    bool found = length == strlen(text) && strstr(text, part) != NULL;
    if (!found) {
        printf("\"%s\" does not say \"%s\"\n", text, part);
    }
    return found;
}

// A pointer that is one byte off.
static void *off(void *pointer) { return (char *)pointer + 1; }

static void memory_and_settings(void) {
    CompassSettings board = compass_settings(COMPASS_PRESET_BOARD), full = compass_settings(COMPASS_PRESET_FULL);
    size_t need = compass_memory_bytes(WIDTH, HEIGHT, &board), least = compass_memory_bytes(0, 0, &board);
    IS(compass_version(), COMPASS_VERSION);
    IS(need <= COMPASS_MEMORY_368X360 && need > COMPASS_MEMORY_368X360 - 20000, true);
    IS(compass_memory_bytes(WIDTH, HEIGHT, &full) > need, true);
    IS(compass_memory_bytes(WIDTH, HEIGHT, NULL), 0);
    IS(compass_memory_bytes(65535, 65535, &board), 0);

    uint8_t *memory = malloc(need + COMPASS_ALIGNMENT);
    Compass *compass = (Compass *)memory;
    EXPECT(NULL, compass_new(NULL, need, &board, &compass));
    IS(compass == NULL, true);
    EXPECT(NULL, compass_new(memory, need, NULL, &compass));
    EXPECT(NULL, compass_new(memory, need, &board, NULL));
    for (int offset = 1; offset < COMPASS_ALIGNMENT; offset++) {
        EXPECT(ALIGNMENT, compass_new(memory + offset, need, &board, &compass));
    }
    EXPECT(MEMORY, compass_new(memory, 0, &board, &compass));
    EXPECT(MEMORY, compass_new(memory, SIZE_MAX, &board, &compass));
    IS(compass == NULL, true);

    CompassSettings none = compass_settings((CompassPreset)7), zero = {0};
    EXPECT(SETTINGS, compass_new(memory, need, &none, &compass));
    EXPECT(SETTINGS, compass_new(memory, need, &zero, &compass));
    CompassSettings wrong[13];
    for (size_t i = 0; i < COUNT(wrong); i++) {
        wrong[i] = board;
    }
    wrong[0].segments = 0;
    wrong[1].boxes = 65537;
    wrong[2].windows = UINT32_MAX;
    wrong[3].vertical_segments = 0;
    wrong[4].pool = 4097;
    wrong[5].headings = 41;
    wrong[6].panorama_per_degree = 3;
    wrong[7].lens_field_mask = 2;
    wrong[8].smoothing = (CompassSmoothing)-1;
    wrong[9].effort.refined_poses = 49;
    wrong[10].effort_at_known_height.refined_fully = 0;
    wrong[11].effort.rays = 3;
    wrong[12].effort.refined_poses = 7;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        EXPECT(SETTINGS, compass_new(memory, need, &wrong[i], &compass));
        IS(compass_memory_bytes(WIDTH, HEIGHT, &wrong[i]), 0);
    }

    // Memory that is too short for the cameras says by how much, and keeps no camera.
    size_t shorter = need - 1000;
    EXPECT(OK, compass_new(memory, shorter, &board, &compass));
    EXPECT(MEMORY, compass_set_camera(compass, 0, &front));
    IS(says(compass, "1000 bytes are missing"), true);
    EXPECT(OK, compass_new(memory, least, &board, &compass));
    CompassFrame seen = frame(0);
    EXPECT(MEMORY, compass_set_camera(compass, 1, &back));
    EXPECT(ORDER, compass_see(compass, &seen, NULL, &prior));
    free(memory);
}

static void handles(void) {
    CompassSettings board = compass_settings(COMPASS_PRESET_BOARD);
    uint8_t *memory = calloc(1, COMPASS_MEMORY_368X360), *copy = malloc(COMPASS_MEMORY_368X360);
    Compass *compass = (Compass *)memory, *made;
    CompassFix fix;
    // Never begun; overwritten; moved; ended.
    EXPECT(HANDLE, compass_forget(compass));
    memset(memory, 0xa5, COMPASS_MEMORY_368X360);
    EXPECT(HANDLE, compass_locate(compass, &prior, &fix));
    EXPECT(OK, compass_new(memory, COMPASS_MEMORY_368X360, &board, &made));
    IS(made == compass, true);
    EXPECT(OK, compass_forget(compass));
    memcpy(copy, memory, COMPASS_MEMORY_368X360);
    EXPECT(HANDLE, compass_forget((Compass *)copy));
    EXPECT(HANDLE, compass_forget(off(compass)));
    EXPECT(OK, compass_end(compass));
    EXPECT(HANDLE, compass_end(compass));
    EXPECT(HANDLE, compass_add_site(compass, site, site_bytes));
    EXPECT(HANDLE, compass_set_camera(compass, 0, &front));
    EXPECT(HANDLE, compass_see(compass, NULL, NULL, &prior));
    IS(says(compass, "no Compass"), true);
    // Nulls.
    EXPECT(NULL, compass_end(NULL));
    EXPECT(NULL, compass_forget(NULL));
    EXPECT(NULL, compass_add_site(NULL, site, site_bytes));
    EXPECT(NULL, compass_set_camera(NULL, 0, &front));
    EXPECT(NULL, compass_see(NULL, NULL, NULL, &prior));
    EXPECT(NULL, compass_locate(NULL, &prior, &fix));
    EXPECT(NULL, compass_track(NULL, 0, NULL, NULL));
    EXPECT(NULL, compass_describe(NULL, NULL, NULL));
    IS(says(NULL, "null"), true);
    free(memory);
    free(copy);
}

static void sites(Compass *compass) {
    EXPECT(NULL, compass_add_site(compass, NULL, 5));
    EXPECT(SITE, compass_add_site(compass, site, 0));
    EXPECT(SITE, compass_add_site(compass, site, SIZE_MAX));
    EXPECT(SITE, compass_add_site(compass, site, site_bytes - 1));
    EXPECT(SITE, compass_add_site(compass, gray[0], GRAY_BYTES));
    IS(says(compass, "not a site"), true);
    site[site_bytes / 2] ^= 1;
    EXPECT(SITE, compass_add_site(compass, site, site_bytes));
    IS(says(compass, "checksum"), true);
    site[site_bytes / 2] ^= 1;
}

static void cameras(Compass *compass) {
    EXPECT(CAMERA, compass_set_camera(compass, 2, &front));
    EXPECT(CAMERA, compass_set_camera(compass, 255, NULL));
    CompassCamera wrong[14];
    for (size_t i = 0; i < COUNT(wrong); i++) {
        wrong[i] = front;
    }
    wrong[0].lens.fx = NAN;
    wrong[1].lens.cy = INFINITY;
    wrong[2].lens.fy = 0;
    wrong[3].lens.model = (CompassLensModel)0;
    wrong[4].lens.parameters.kannala_brandt.k[0] = -1e20f;
    wrong[5].width = 0;
    wrong[6].height = 0;
    wrong[7].width = wrong[7].height = 65535;
    wrong[8].rotation[0] = -1;
    memset(wrong[9].rotation, 0, sizeof wrong[9].rotation);
    wrong[10].rotation[4] = NAN;
    wrong[11].position_m[2] = NAN;
    memcpy(wrong[12].rotation, back.rotation, sizeof back.rotation);
    wrong[13].position_m[0] = 5;
    for (size_t i = 0; i < COUNT(wrong); i++) {
        EXPECT(CAMERA, compass_set_camera(compass, 0, &wrong[i]));
        IS(says(compass, "cam0"), true);
    }
    CompassCamera eucm = front;
    eucm.lens.model = COMPASS_LENS_MODEL_EUCM;
    eucm.lens.parameters.eucm = (CompassEucm){.alpha = 1.5f, .beta = 1};
    EXPECT(CAMERA, compass_set_camera(compass, 0, &eucm));
    IS(says(compass, "alpha"), true);
    eucm.lens.parameters.eucm = (CompassEucm){.alpha = 0.6f, .beta = NAN};
    EXPECT(CAMERA, compass_set_camera(compass, 0, &eucm));
    eucm.lens.parameters.eucm.beta = 1.1f;
    EXPECT(OK, compass_set_camera(compass, 0, &eucm));
    EXPECT(ALIGNMENT, compass_set_camera(compass, 0, off(&eucm)));
    CompassCamera spheres = front;
    spheres.lens.model = COMPASS_LENS_MODEL_DOUBLE_SPHERE;
    spheres.lens.parameters.double_sphere = (CompassDoubleSphere){.xi = -1.5f, .alpha = 0.6f};
    EXPECT(CAMERA, compass_set_camera(compass, 0, &spheres));
    IS(says(compass, "xi"), true);
    spheres.lens.parameters.double_sphere.xi = -0.2f;
    EXPECT(OK, compass_set_camera(compass, 0, &spheres));
    CompassCamera omni = front;
    omni.lens.model = COMPASS_LENS_MODEL_OMNI;
    omni.lens.parameters.omni = (CompassOmni){.xi = 1.2f, .k = {NAN}};
    EXPECT(CAMERA, compass_set_camera(compass, 0, &omni));
    omni.lens.parameters.omni = (CompassOmni){.xi = 1.2f, .k = {-0.1f, 0.02f}, .p = {0.001f, -0.001f}};
    EXPECT(OK, compass_set_camera(compass, 0, &omni));
    EXPECT(OK, compass_set_camera(compass, 0, NULL));
}

static void frames(Compass *compass) {
    CompassFrame first = frame(0), second = frame(1), other;
    EXPECT(NULL, compass_see(compass, &first, &second, NULL));
    EXPECT(FRAME, compass_see(compass, NULL, NULL, &prior));
    EXPECT(FRAME, compass_see(compass, &first, NULL, &prior));
    IS(says(compass, "cam1"), true);
    EXPECT(ALIGNMENT, compass_see(compass, off(&first), &second, &prior));
    other = first, other.width = WIDTH - 1;
    EXPECT(FRAME, compass_see(compass, &other, &second, &prior));
    IS(says(compass, "367 x 360"), true);
    other = first, other.height = 0;
    EXPECT(FRAME, compass_see(compass, &other, &second, &prior));
    other = first, other.gray_bytes--;
    EXPECT(FRAME, compass_see(compass, &other, &second, &prior));
    IS(says(compass, "132479"), true);
    other = first, other.gray = NULL;
    EXPECT(NULL, compass_see(compass, &other, &second, &prior));
    other = first, other.excluded_bytes = 0;
    EXPECT(FRAME, compass_see(compass, &other, &second, &prior));
    other = first, other.excluded = NULL;
    EXPECT(FRAME, compass_see(compass, &other, &second, &prior));
    // A frame of a camera that is not there.
    EXPECT(OK, compass_set_camera(compass, 1, NULL));
    EXPECT(FRAME, compass_see(compass, &first, &second, &prior));
    EXPECT(OK, compass_set_camera(compass, 1, &back));
    // Nothing but gray: no vertical lines.
    uint8_t *blank = calloc(1, GRAY_BYTES);
    other = (CompassFrame){.gray = blank, .gray_bytes = GRAY_BYTES, .width = WIDTH, .height = HEIGHT};
    EXPECT(UP, compass_see(compass, &other, &other, &prior));
    free(blank);
}

static void priors(Compass *compass) {
    CompassFrame first = frame(0), second = frame(1);
    CompassFix fix;
    const float ups[][3] = {{0, 0, 0}, {NAN, 1, 0}, {0, INFINITY, 0}, {0, 0, -INFINITY}};
    for (size_t i = 0; i < COUNT(ups); i++) {
        CompassPrior wrong = prior;
        memcpy(wrong.up, ups[i], sizeof ups[i]);
        EXPECT(PRIOR, compass_see(compass, &first, &second, &wrong));
        wrong.up_kind = COMPASS_UP_KIND_EXACT;
        EXPECT(PRIOR, compass_see(compass, &first, &second, &wrong));
    }
    CompassPrior wrong = {0};
    EXPECT(PRIOR, compass_see(compass, &first, &second, &wrong));
    wrong = (CompassPrior){.up_kind = COMPASS_UP_KIND_EXACT, .up = {0, 0, 1}};
    EXPECT(AXIS, compass_see(compass, &first, &second, &wrong));

    // Up may be unknown, or known exactly; its length does not matter.
    CompassPrior other = prior;
    other.up_kind = COMPASS_UP_KIND_UNKNOWN;
    EXPECT(OK, compass_see(compass, &first, &second, &other));
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    IS(compass_metres(fix.poses[0].x) > 4.0 && compass_metres(fix.poses[0].x) < 4.3, true);
    other.up_kind = COMPASS_UP_KIND_EXACT, other.up[1] = 1e-30f;
    EXPECT(OK, compass_see(compass, &first, &second, &other));

    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    const float heights[] = {NAN, -1, 0, 0.5f, 2.5f, 1e30f, INFINITY};
    for (size_t i = 0; i < COUNT(heights); i++) {
        wrong = prior, wrong.camera_height_m = heights[i];
        EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
        IS(fix.count, 0);
    }
    wrong = prior, wrong.height_kind = (CompassHeightKind)0;
    EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    wrong.height_kind = COMPASS_HEIGHT_KIND_BOTH, wrong.heights = (CompassHeights){.camera = 127, .ceiling = 0};
    EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    wrong = prior, wrong.place_kind = (CompassPlaceKind)0;
    EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    wrong.place_kind = (CompassPlaceKind)(COMPASS_PLACE_KIND_ANYWHERE | COMPASS_PLACE_KIND_NEAR);
    EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    const float radii[] = {NAN, -1, 0, 1e30f, INFINITY};
    for (size_t i = 0; i < COUNT(radii); i++) {
        wrong = prior, wrong.place_kind = COMPASS_PLACE_KIND_NEAR, wrong.near_radius_m = radii[i];
        EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    }
    wrong = prior, wrong.place_kind = COMPASS_PLACE_KIND_HEADING;
    EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    wrong.place_kind = COMPASS_PLACE_KIND_FLOOR, wrong.floor = 200;
    EXPECT(PRIOR, compass_locate(compass, &wrong, &fix));
    EXPECT(NULL, compass_locate(compass, NULL, &fix));
    EXPECT(NULL, compass_locate(compass, &prior, NULL));
    // Told where to look, it finds the same there and nothing elsewhere.
    CompassFix told;
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    IS(fix.covariances[0][0] > 0 && fix.covariances[0][4] > 0 && fix.covariances[0][8] > 0, true);
    wrong = prior;
    wrong.place_kind = (CompassPlaceKind)(COMPASS_PLACE_KIND_NEAR | COMPASS_PLACE_KIND_HEADING | COMPASS_PLACE_KIND_FLOOR);
    wrong.near_x = fix.poses[0].x, wrong.near_y = fix.poses[0].y, wrong.near_radius_m = 0.5f;
    wrong.heading = fix.poses[0].heading, wrong.heading_width = 1u << 27, wrong.floor = 0;
    EXPECT(OK, compass_locate(compass, &wrong, &told));
    IS(told.count, 1);
    IS(fabs(compass_metres(told.poses[0].x - fix.poses[0].x)) < 0.05, true);
    wrong.near_x = compass_coordinate(1e6), wrong.near_y = 0;
    EXPECT(NOWHERE, compass_locate(compass, &wrong, &told));
    IS(told.count, 0);
    // What a fix says of heights, the next prior may say.
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    wrong = prior, wrong.height_kind = COMPASS_HEIGHT_KIND_BOTH, wrong.heights = fix.heights;
    EXPECT(OK, compass_locate(compass, &wrong, &fix));
}

// Answers are of the frames that were seen last, or there is none.
static void orders(Compass *compass) {
    CompassFrame first = frame(0), second = frame(1);
    CompassFix fix;
    CompassEstimate estimate;
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(ORDER, compass_track(compass, 0, NULL, &estimate));
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    IS(strcmp(fix.poses[0].floor_name, "ground"), 0);
    IS(compass_last_error(compass, NULL, 0), 0);
    // A look that fails leaves neither what was seen nor what was found.
    EXPECT(FRAME, compass_see(compass, &first, NULL, &prior));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    IS(fix.count, 0);
    EXPECT(ORDER, compass_track(compass, 0, NULL, &estimate));
    // So does one that is refused for its arguments, or a change of the cameras.
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(NULL, compass_see(compass, &first, &second, NULL));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(OK, compass_set_camera(compass, 0, NULL));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    EXPECT(OK, compass_set_camera(compass, 1, NULL));
    EXPECT(ORDER, compass_see(compass, &first, &second, &prior));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    EXPECT(OK, compass_set_camera(compass, 0, &front));
    EXPECT(OK, compass_set_camera(compass, 1, &back));
}

static void tracks(Compass *compass) {
    CompassFrame first = frame(0), second = frame(1);
    CompassFix fix;
    CompassEstimate estimate, again;
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    const float seconds[] = {NAN, -1, INFINITY, -INFINITY};
    for (size_t i = 0; i < COUNT(seconds); i++) {
        EXPECT(MOTION, compass_track(compass, seconds[i], NULL, &estimate));
    }
    const CompassMotion motions[] = {{NAN, 0, 0}, {0, INFINITY, 0}, {0, 0, -INFINITY}};
    for (size_t i = 0; i < COUNT(motions); i++) {
        EXPECT(MOTION, compass_track(compass, 1, &motions[i], &estimate));
        IS(estimate.probability == 0, true);
    }
    EXPECT(NULL, compass_track(compass, 0, NULL, NULL));
    EXPECT(OK, compass_track(compass, 0, NULL, &estimate));
    IS(strcmp(estimate.pose.floor_name, "ground"), 0);
    // One look counts once, located again or not.
    EXPECT(ORDER, compass_track(compass, 1, NULL, &again));
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    EXPECT(ORDER, compass_track(compass, 1, NULL, &again));
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(OK, compass_locate(compass, &prior, &fix));
    EXPECT(OK, compass_track(compass, 1, NULL, &again));
    IS(again.probability > estimate.probability, true);
    EXPECT(OK, compass_forget(compass));
}

static void descriptions(Compass *compass) {
    CompassScan scan;
    CompassPose pose = {.x = compass_coordinate(4.349), .y = compass_coordinate(17.669)};
    EXPECT(OK, compass_describe(compass, &pose, &scan));
    EXPECT(NULL, compass_describe(compass, NULL, &scan));
    EXPECT(NULL, compass_describe(compass, &pose, NULL));
    EXPECT(ALIGNMENT, compass_describe(compass, &pose, off(&scan)));
    pose.floor = 9;
    EXPECT(FLOOR, compass_describe(compass, &pose, &scan));
    pose.floor = 0, pose.layer = 2;
    EXPECT(FLOOR, compass_describe(compass, &pose, &scan));
    pose.layer = 0, pose.x = INT64_MIN, pose.y = INT64_MAX;
    EXPECT(OUTSIDE, compass_describe(compass, &pose, &scan));
}

// More layers than there is room for: none of that site is added.
static void layers(Compass *compass) {
    CompassStatus status;
    int added = 1;
    while ((status = compass_add_site(compass, site, site_bytes)) == COMPASS_STATUS_OK) {
        added++;
    }
    EXPECT(LAYERS, status);
    IS(says(compass, "16 layers"), true);
    CompassPose pose = {.x = compass_coordinate(4.349), .y = compass_coordinate(17.669), .floor = (uint8_t)(added - 1)};
    CompassScan scan;
    EXPECT(OK, compass_describe(compass, &pose, &scan));
    pose.floor++;
    EXPECT(FLOOR, compass_describe(compass, &pose, &scan));
}

static void sentences(Compass *compass) {
    EXPECT(CAMERA, compass_set_camera(compass, 7, NULL));
    char text[8];
    memset(text, '#', sizeof text);
    size_t length = compass_last_error(compass, text, 6);
    IS(length > 20 && strlen(text) == 5 && text[6] == '#' && text[7] == '#', true);
    IS(compass_last_error(compass, NULL, 100), length);
    memset(text, '#', sizeof text);
    IS(compass_last_error(compass, text, 0), length);
    IS(text[0], '#');
    for (int status = -2; status < 25; status++) {
        IS(strlen(compass_status_text((CompassStatus)status)) > 10, true);
    }
}

int main(int count, char **arguments) {
    if (count != 2) {
        return 2;
    }
    size_t length;
    site = read_file(arguments[1], "sample.site", &site_bytes);
    for (int camera = 0; camera < 2; camera++) {
        char name[32];
        snprintf(name, sizeof name, "frame_368x360_cam%d.gray", camera);
        gray[camera] = read_file(arguments[1], name, &length);
        snprintf(name, sizeof name, "frame_368x360_cam%d.red", camera);
        excluded[camera] = read_file(arguments[1], name, &length);
    }
    memory_and_settings();
    handles();

    // Not a byte more than asked for.
    CompassSettings board = compass_settings(COMPASS_PRESET_BOARD);
    size_t need = compass_memory_bytes(WIDTH, HEIGHT, &board);
    uint8_t *memory = malloc(need + GUARD);
    memset(memory, 0x5a, need + GUARD);
    Compass *compass;
    CompassFix fix;
    CompassFrame first = frame(0), second = frame(1);
    EXPECT(OK, compass_new(memory, need, &board, &compass));
    EXPECT(ORDER, compass_see(compass, &first, &second, &prior));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    sites(compass);
    cameras(compass);
    EXPECT(OK, compass_set_camera(compass, 0, &front));
    EXPECT(OK, compass_set_camera(compass, 1, &back));
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    IS(says(compass, "site"), true);
    EXPECT(OK, compass_add_site(compass, site, site_bytes));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    frames(compass);
    priors(compass);
    orders(compass);
    tracks(compass);
    descriptions(compass);
    layers(compass);
    sentences(compass);
    // Memory lent anew knows nothing of before.
    EXPECT(OK, compass_see(compass, &first, &second, &prior));
    EXPECT(OK, compass_new(memory, need, &board, &compass));
    EXPECT(ORDER, compass_locate(compass, &prior, &fix));
    EXPECT(OK, compass_end(compass));
    for (size_t i = 0; i < GUARD; i++) {
        IS(memory[need + i], 0x5a);
    }
    printf("misuse: %d of %d expectations hold\n", checked - failed, checked);
    return failed != 0;
}
