// From two frames to a pose, in C: prints what surrounds the pose found, and a checksum of all that was found.
//
//   example DIRECTORY
//
// reads the sample of tests/vectors. The checksum is that of the stage `locate` of targets/golden: equal bits.
#include "compass.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 368
#define HEIGHT 360

// What a board would have in flash or in a camera's buffer.
static uint8_t map[300000], plan[400000], gray[2][WIDTH * HEIGHT], red[2][(WIDTH + 7) / 8 * HEIGHT];
static uint64_t memory[COMPASS_MEMORY_368X360 / 8];

static const CompassCamera cameras[2] = {
    {.fx = 116.0f, .fy = 116.1f, .cx = 182.95f, .cy = 179.9f,
     .k = {0.024f, -0.0105f, -0.0016f, 0.00014f},
     .width = WIDTH, .height = HEIGHT,
     .rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
    {.fx = 116.25f, .fy = 116.3f, .cx = 183.65f, .cy = 179.2f,
     .k = {0.025f, -0.0107f, -0.00155f, 0.00013f},
     .width = WIDTH, .height = HEIGHT,
     .rotation = {-0.999975f, 0.005025f, 0.004975f, 0.005f, 0.9999747f, -0.005025f, -0.005f, -0.005f, -0.9999749f},
     .position_m = {0.0012f, -0.0007f, -0.038f}},
};

static void require(bool condition, const char *what) {
    if (!condition) {
        fprintf(stderr, "%s\n", what);
        exit(2);
    }
}

static void done(CompassStatus status, const char *what) {
    if (status != COMPASS_STATUS_OK) {
        fprintf(stderr, "%s: status %d\n", what, (int)status);
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
    sum = crc(sum, (uint32_t)(int32_t)fix->height);
    return ~crc(sum, (uint32_t)(int32_t)fix->ceiling);
}

static void print_scan(const Compass *compass, const CompassPose *pose) {
    CompassScan scan;
    done(compass_describe(compass, pose->layer, pose->x, pose->y, pose->heading, &scan), "describe");
    int windows = 0;
    for (int bin = 0; bin < COMPASS_BINS; bin++) {
        windows += scan.hit[bin] == 1;
    }
    printf("around   %.2f m ahead, %.2f m to the left, %d of 360 directions glazed\n",
           scan.steps[0] * COMPASS_STEP_MM / 1000.0, scan.steps[90] * COMPASS_STEP_MM / 1000.0, windows);
}

int main(int count, char **arguments) {
    require(count == 2, "usage: example DIRECTORY");
    const char *directory = arguments[1];
    size_t map_bytes = read_file(directory, "sample_map.bin", map, sizeof map);
    size_t plan_bytes = read_file(directory, "sample_plan.bin", plan, sizeof plan);

    require(sizeof memory >= compass_memory_bytes(WIDTH, HEIGHT, false), "memory is too short");
    Compass *compass = compass_new((uint8_t *)memory, sizeof memory);
    require(compass != NULL, "memory is too short for anything");
    done(compass_add_floor(compass, map, map_bytes, plan, plan_bytes), "floor");
    for (uint8_t number = 0; number < 2; number++) {
        done(compass_set_camera(compass, number, &cameras[number]), "camera");
    }

    CompassFrame frames[2];
    for (int number = 0; number < 2; number++) {
        char name[32];
        snprintf(name, sizeof name, "frame_368x360_cam%d.gray", number);
        require(read_file(directory, name, gray[number], sizeof gray[number]) == sizeof gray[number], name);
        snprintf(name, sizeof name, "frame_368x360_cam%d.red", number);
        require(read_file(directory, name, red[number], sizeof red[number]) == sizeof red[number], name);
        frames[number] = (CompassFrame){.gray = gray[number], .red = red[number]};
    }
    // The rig hangs upside down: the image's down is up.
    const float up[3] = {0, 1, 0};
    done(compass_see(compass, frames, up), "see");

    const CompassRoom room = {.camera_height_m = 1.6f, .places = 8, .ceilings = 1};
    CompassFix fix;
    done(compass_locate(compass, &room, &fix), "locate");
    const CompassPose *best = &fix.poses[0];
    printf("found    x %.3f m  y %.3f m  heading %.1f degrees, probability %.2f, cameras %.2f m above the floor\n",
           compass_metres(best->x), compass_metres(best->y), compass_degrees(best->heading), fix.probability,
           fix.height_m);
    print_scan(compass, best);

    CompassEstimate estimate;
    done(compass_track(compass, 0, NULL, &estimate), "track");
    printf("believed x %.3f m  y %.3f m, probability %.2f\n", compass_metres(estimate.pose.x),
           compass_metres(estimate.pose.y), estimate.probability);
    printf("check locate 0x%08x\n", (unsigned)checksum(&fix));
    return 0;
}
