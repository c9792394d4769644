// COMPASS: where am I in this building? From floor plan and frames to a pose, without heap.
//
// Made from src/ by `REGENERATE=1 cargo test` in targets/c; a test fails where the two differ.
//
// One thread at a time may use a Compass. No function keeps a pointer but those to sites, floors and memory.

#ifndef COMPASS_H
#define COMPASS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
// Metres of a coordinate.
static inline double compass_metres(int64_t coordinate) { return (double)coordinate / 4294967296.0; }

// The coordinate of a position in metres.
static inline int64_t compass_coordinate(double metres) { return (int64_t)(metres * 4294967296.0); }

// Degrees of a heading, 0 to 360, counter-clockwise from +x.
static inline double compass_degrees(uint32_t heading) { return heading * (360.0 / 4294967296.0); }

// Directions of a scan: direction j looks along heading + j degrees, counter-clockwise.
#define COMPASS_BINS 360

// Millimetres in a step of a range.
#define COMPASS_STEP_MM 20

// Most poses of a fix: the best and its alternatives.
#define COMPASS_MAX_POSES 10

// Most layers of floors that a Compass holds: of a site file two for each floor, the plan and its structure.
#define COMPASS_MAX_LAYERS 16

// Bytes of memory for frames of 368 x 360 pixels.
#define COMPASS_MEMORY_368X360 482000

// What became of a call.
typedef enum CompassStatus {
  // Done.
  COMPASS_STATUS_OK = 0,
  // A pointer is null that must not be, or a number makes no sense.
  COMPASS_STATUS_ARGUMENT = 1,
  // The memory is too short, or not aligned to 8 bytes.
  COMPASS_STATUS_MEMORY = 2,
  // The bytes are no site file, or no site map with the plan it was made from; or they are damaged.
  COMPASS_STATUS_SITE = 3,
  // More than COMPASS_MAX_LAYERS layers.
  COMPASS_STATUS_FULL = 4,
  // The position lies outside the plan.
  COMPASS_STATUS_OUTSIDE = 5,
  // The position lies inside a wall or glazing.
  COMPASS_STATUS_OCCUPIED = 6,
  // The frames are not those of the cameras that were set.
  COMPASS_STATUS_CAMERA = 7,
  // Too few upright lines were seen to tell which way is up.
  COMPASS_STATUS_UP = 8,
  // The step before was not done.
  COMPASS_STATUS_ORDER = 9,
  // There is no pose: no layer was added, or nothing fits.
  COMPASS_STATUS_NOWHERE = 10,
} CompassStatus;

// All that COMPASS knows, in memory that the caller lends.
typedef struct Compass Compass;

// Range and hit type all around.
typedef struct CompassScan {
  // Ranges in steps of COMPASS_STEP_MM, 1 to 1500.
  uint16_t steps[COMPASS_BINS];
  // What is there: 0 nothing within 30 m, 1 glazing, 2 a wall.
  uint8_t hit[COMPASS_BINS];
} CompassScan;

// A fisheye camera: lens of Kannala and Brandt ("equidistant" in Kalibr, "fisheye" in OpenCV). Axes are x right, y
// down, z forward.
typedef struct CompassCamera {
  // Focal lengths, pixels.
  float fx;
  // Focal lengths, pixels.
  float fy;
  // Principal point, pixels.
  float cx;
  // Principal point, pixels.
  float cy;
  // Coefficients of the lens.
  float k[4];
  // Pixels along x.
  uint16_t width;
  // Pixels along y.
  uint16_t height;
  // Turns bearings of this camera into bearings of camera 0, row by row: the identity for camera 0.
  float rotation[9];
  // Where this camera is in the axes of camera 0, metres: zeros for camera 0.
  float position_m[3];
} CompassCamera;

// What a camera saw.
typedef struct CompassFrame {
  // Gray levels, row by row, of the camera's width and height; null if there is no frame of this camera.
  const uint8_t *gray;
  // One bit a pixel, set where it is red (safety gear in front of a window): rows of (width + 7) / 8 bytes, the first
  // pixel in the lowest bit; null if that is not known.
  const uint8_t *red;
} CompassFrame;

// What is known beforehand, and how much work the search may do.
typedef struct CompassRoom {
  // Height of the cameras above the floor, metres; 0 if it is to be found as well, which takes 2 to 5 times as long in all.
  float camera_height_m;
  // Places to look at closely, 1 to 48: 8 do if the height is told, 24 if it is not.
  uint8_t places;
  // Heights of the ceiling to try until an answer is sure: 1 does if the camera's height is told, 3 if it is not.
  uint8_t ceilings;
} CompassRoom;

// A pose on a floor.
typedef struct CompassPose {
  // Map coordinate in 1/2^32 m: see compass_metres.
  int64_t x;
  // Map coordinate in 1/2^32 m: see compass_metres.
  int64_t y;
  // Heading of camera 0 in 1/2^32 turn, counter-clockwise from +x: see compass_degrees.
  uint32_t heading;
  // Log-likelihood ratio against knowing nothing, 1/16 nat.
  int32_t score;
  // Number of the layer, in the order in which they were added.
  uint8_t layer;
} CompassPose;

// Where the cameras are.
typedef struct CompassFix {
  // The best pose and its alternatives, best first.
  struct CompassPose poses[COMPASS_MAX_POSES];
  // How many they are.
  uint32_t count;
  // How likely the best is within 1 m of the true one, 0 to 1.
  float probability;
  // Height of the cameras above the floor, metres, to 3 %: that given, or that found.
  float height_m;
  // The same as a step of 6.3 %, 0 for 1.5 m.
  int8_t height;
  // How many such steps the ceiling is higher above the cameras than the floor is below them.
  int8_t ceiling;
} CompassFix;

// How the cameras moved since the frames before, in the level axes they had then: forward is where camera 0 looked.
typedef struct CompassMotion {
  // Metres.
  float forward_m;
  // Metres.
  float left_m;
  // Radians, counter-clockwise.
  float turn;
} CompassMotion;

// What is believed after a sequence of frames.
typedef struct CompassEstimate {
  // The likeliest pose.
  struct CompassPose pose;
  // Its probability.
  float probability;
  // Root mean square distance of what else is possible on its floor, metres.
  float spread_m;
} CompassEstimate;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Bytes of memory for frames of this size; `fine` tells whether the lenses have 3 pixels a degree or more, that is a
// focal length of 172 or more.
size_t compass_memory_bytes(uint16_t width,
                            uint16_t height,
                            bool fine);

// Begins: a Compass in this memory, which must be aligned to 8 bytes and is used as long as the Compass is. Null if it
// is too short even without frames, not aligned, or null. There is nothing to be freed.
//
// # Safety
// `memory` is null or points to as many bytes, which nobody else uses.
struct Compass *compass_new(uint8_t *memory,
                            size_t bytes);

// Adds all layers of all floors of a site file (`compass map build`), which is read in place: it must stay as it is as
// long as the Compass is used. Checksums are compared, which reads the file once. Site, Full (then none is added).
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_add_site(struct Compass *compass,
                                    const uint8_t *site,
                                    size_t bytes);

// Adds one floor: its site map, and the packed plan it was made from, like a site file. Site, Full.
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_add_floor(struct Compass *compass,
                                     const uint8_t *map,
                                     size_t map_bytes,
                                     const uint8_t *plan,
                                     size_t plan_bytes);

// What surrounds a position in a layer's plan, cast with 360 rays; `x` and `y` as in CompassPose. Argument, Outside,
// Occupied.
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_describe(const struct Compass *compass,
                                    uint8_t layer,
                                    int64_t x,
                                    int64_t y,
                                    uint32_t heading,
                                    struct CompassScan *scan);

// Tells a camera, number 0 or 1; null takes it away. Argument for numbers that make no lens, no rotation or no size.
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_set_camera(struct Compass *compass,
                                      uint8_t number,
                                      const struct CompassCamera *camera);

// Looks at the two frames, of all cameras that were set; `up` is roughly the upward direction in the axes of camera 0,
// three numbers: a vector of any length. Argument, Camera, Memory, Up.
//
// # Safety
// Pointers are null or point to what they say; frames are as large as their cameras say.
enum CompassStatus compass_see(struct Compass *compass,
                               const struct CompassFrame *frames,
                               const float *up);

// Finds the pose that explains best what was seen, over all layers. Argument, Order (nothing was seen), Nowhere.
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_locate(struct Compass *compass,
                                  const struct CompassRoom *room,
                                  struct CompassFix *fix);

// Takes the frames that were just located into the belief over the sequence: `seconds` since the frames before, 0 for
// the first; `motion` as measured since then, or null. Argument, Order (nothing was located), Nowhere.
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_track(struct Compass *compass,
                                 float seconds,
                                 const struct CompassMotion *motion,
                                 struct CompassEstimate *estimate);

// Forgets the sequence. Argument.
//
// # Safety
// Pointers are null or point to what they say.
enum CompassStatus compass_forget(struct Compass *compass);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* COMPASS_H */
