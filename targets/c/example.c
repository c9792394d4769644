// From two frames to a pose, in C: prints the pose with the name of its floor, what surrounds it, what wrong use is
// answered with, and a checksum of all that was found.
//
//   example DIRECTORY
//
// reads the sample of tests/vectors. The checksum is that of the stage `locate` of targets/golden: equal bits.
#include "compass.h"

#include <math.h>
#include <stdalign.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 368
#define HEIGHT 360

// What a board would have in flash or in a camera's buffer.
static uint8_t site[1000000], gray[2][WIDTH * HEIGHT], excluded[2][(WIDTH + 7) / 8 * HEIGHT];
static alignas(COMPASS_ALIGNMENT) uint8_t memory[COMPASS_MEMORY_368X360];

static const CompassCamera cameras[2] = {
    {.lens = {.model = COMPASS_LENS_MODEL_KANNALA_BRANDT,
              .fx = 116.0f, .fy = 116.1f, .cx = 182.95f, .cy = 179.9f,
              .parameters.kannala_brandt.k = {0.024f, -0.0105f, -0.0016f, 0.00014f}},
     .width = WIDTH, .height = HEIGHT,
     .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
    {.lens = {.model = COMPASS_LENS_MODEL_KANNALA_BRANDT,
              .fx = 116.25f, .fy = 116.3f, .cx = 183.65f, .cy = 179.2f,
              .parameters.kannala_brandt.k = {0.025f, -0.0107f, -0.00155f, 0.00013f}},
     .width = WIDTH, .height = HEIGHT,
     .rotation = {-0.999975f, 0.005025f, 0.004975f, 0.005f, 0.9999747f, -0.005025f, -0.005f, -0.005f, -0.9999749f},
     .position_m = {0.0012f, -0.0007f, -0.038f}},
};

// The rig hangs upside down, so that the image's down is up; the cameras are 1.6 m above the floor.
static const CompassPrior prior = {
    .up_kind = COMPASS_UP_KIND_NEAR, .up = {0, 1, 0},
    .height_kind = COMPASS_HEIGHT_KIND_CAMERA, .camera_height_m = 1.6f,
    .place_kind = COMPASS_PLACE_KIND_ANYWHERE,
};

static void require(bool condition, const char *what) {
    if (!condition) {
        fprintf(stderr, "%s\n", what);
        exit(2);
    }
}

// Ends the program with what went wrong unless a call succeeded.
static void done(const Compass *compass, CompassStatus status) {
    if (status != COMPASS_STATUS_OK) {
        char error[160];
        compass_last_error(compass, error, sizeof error);
        fprintf(stderr, "%s (%s)\n", compass_status_text(status), error);
        exit(1);
    }
}

static size_t read_file(const char *directory, const char *name, uint8_t *bytes, size_t most) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *file = fopen(path, "rb");
    require(file != NULL, path);
    size_t length = fread(bytes, 1, most, file);
    fclose(file);
    return length;
}

static CompassFrame read_frame(const char *directory, int camera) {
    char name[32];
    snprintf(name, sizeof name, "frame_368x360_cam%d.gray", camera);
    size_t gray_bytes = read_file(directory, name, gray[camera], sizeof gray[camera]);
    snprintf(name, sizeof name, "frame_368x360_cam%d.red", camera);
    size_t excluded_bytes = read_file(directory, name, excluded[camera], sizeof excluded[camera]);
    return (CompassFrame){
        .gray = gray[camera], .gray_bytes = gray_bytes,
        .excluded = excluded[camera], .excluded_bytes = excluded_bytes,
        .width = WIDTH, .height = HEIGHT,
    };
}

// CRC-32 (that of zip) of a word in little-endian order, continued.
static uint32_t crc(uint32_t sum, uint32_t word) {
    for (int bit = 0; bit < 32; bit++, word >>= 1) {
        sum = (sum >> 1) ^ ((sum ^ word) & 1 ? 0xedb88320u : 0);
    }
    return sum;
}

static uint32_t checksum(const CompassFix *fix) {
    uint32_t sum = ~0u;
    for (uint32_t i = 0; i < fix->count; i++) {
        const CompassPose *pose = &fix->poses[i];
        sum = crc(sum, (uint32_t)pose->x);
        sum = crc(sum, (uint32_t)((uint64_t)pose->x >> 32));
        sum = crc(sum, (uint32_t)pose->y);
        sum = crc(sum, (uint32_t)((uint64_t)pose->y >> 32));
        sum = crc(sum, pose->heading);
        sum = crc(sum, (uint32_t)pose->score);
    }
    for (uint32_t i = 0; i < fix->count; i++) {
        for (int value = 0; value < 9; value++) {
            uint32_t bits;
            memcpy(&bits, &fix->covariances[i][value], sizeof bits);
            sum = crc(sum, bits);
        }
    }
    sum = crc(sum, (uint32_t)(int32_t)fix->heights.camera);
    return ~crc(sum, (uint32_t)(int32_t)fix->heights.ceiling);
}

static void print_scan(Compass *compass, const CompassPose *pose) {
    CompassScan scan;
    done(compass, compass_describe(compass, pose, &scan));
    int windows = 0;
    for (int bin = 0; bin < COMPASS_BINS; bin++) {
        windows += scan.hit[bin] == 1;
    }
    printf("around   %.2f m ahead, %.2f m to the left, %d of 360 directions glazed\n",
           scan.steps[0] * COMPASS_STEP_MM / 1000.0, scan.steps[90] * COMPASS_STEP_MM / 1000.0, windows);
}

static void refused(const char *call, const Compass *compass, CompassStatus status) {
    char error[160];
    compass_last_error(compass, error, sizeof error);
    printf("refused  %-15s %2d  %s\n", call, (int)status, error);
}

// What wrong use is answered with.
static void print_refusals(Compass *compass, const CompassFrame frames[2]) {
    CompassFix fix;
    CompassEstimate estimate;
    CompassFrame small = frames[1];
    small.width = 320;
    CompassPrior nonsense = prior;
    nonsense.up[1] = NAN;
    refused("track again", compass, compass_track(compass, 0, NULL, &estimate));
    refused("camera 2", compass, compass_set_camera(compass, 2, &cameras[1]));
    refused("NaN", compass, compass_see(compass, &frames[0], &frames[1], &nonsense));
    refused("small frame", compass, compass_see(compass, &frames[0], &small, &prior));
    refused("missing frame", compass, compass_see(compass, &frames[0], NULL, &prior));
    refused("locate unseen", compass, compass_locate(compass, &prior, &fix));
    done(compass, compass_end(compass));
    refused("after the end", compass, compass_locate(compass, &prior, &fix));
}

int main(int count, char **arguments) {
    require(count == 2, "usage: example DIRECTORY");
    require(compass_version() == COMPASS_VERSION, "the library has another version than the header");
    size_t site_bytes = read_file(arguments[1], "sample.site", site, sizeof site);
    const CompassFrame frames[2] = {read_frame(arguments[1], 0), read_frame(arguments[1], 1)};

    CompassSettings settings = compass_settings(COMPASS_PRESET_BOARD);
    require(sizeof memory >= compass_memory_bytes(WIDTH, HEIGHT, &settings), "memory is too short");
    Compass *compass;
    done(NULL, compass_new(memory, sizeof memory, &settings, &compass));
    done(compass, compass_add_site(compass, site, site_bytes));
    for (uint8_t number = 0; number < 2; number++) {
        done(compass, compass_set_camera(compass, number, &cameras[number]));
    }

    done(compass, compass_see(compass, &frames[0], &frames[1], &prior));
    CompassFix fix;
    done(compass, compass_locate(compass, &prior, &fix));
    const CompassPose *best = &fix.poses[0];
    printf("found    x %.3f m  y %.3f m  heading %.1f degrees, probability %.2f, cameras %.2f m above the floor\n",
           compass_metres(best->x), compass_metres(best->y), compass_degrees(best->heading), fix.probability,
           fix.camera_height_m);
    printf("sigma    x %.3f m  y %.3f m  heading %.2f degrees, if right\n", sqrt(fix.covariances[0][0]),
           sqrt(fix.covariances[0][4]), sqrt(fix.covariances[0][8]) * 57.29578);
    printf("floor    %s (number %d), layer %d\n", best->floor_name, best->floor, best->layer);
    print_scan(compass, best);

    CompassEstimate estimate;
    done(compass, compass_track(compass, 0, NULL, &estimate));
    printf("believed x %.3f m  y %.3f m, probability %.2f\n", compass_metres(estimate.pose.x),
           compass_metres(estimate.pose.y), estimate.probability);
    print_refusals(compass, frames);
    printf("check locate 0x%08x\n", (unsigned)checksum(&fix));
    return 0;
}
