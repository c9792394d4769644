// COMPASS: where am I in this building? From a site file and the frames of one or two cameras to a pose, without heap.
//
// Made from src/ by `REGENERATE=1 cargo test --test header` in targets/c; a test fails where the two differ.
//
// In order: compass_settings, compass_memory_bytes, compass_new; compass_add_site and compass_set_camera; then for the
// frames of each moment compass_see, compass_locate and, for a sequence, compass_track. Adding a site or setting a camera
// forgets what was seen.
//
// A function that takes a Compass or a struct returns COMPASS_STATUS_NULL, _HANDLE or _ALIGNMENT for a pointer that is none.
// Comments name the codes that it returns beside these, without COMPASS_STATUS_; compass_last_error says more.
//
// What a caller owes, since C cannot check it: pointers that are not null point to what their type or the length beside
// them says; the memory is used by nobody else until compass_end, and sites do not change until then; one thread at a time
// uses a Compass. All else that is wrong is refused with a code.

#ifndef COMPASS_H
#define COMPASS_H

#include <stddef.h>
#include <stdint.h>

// Metres of a coordinate.
static inline double compass_metres(int64_t coordinate) { return (double)coordinate / 4294967296.0; }

// The coordinate of a position in metres, within 2 000 000 000 of 0.
static inline int64_t compass_coordinate(double metres) { return (int64_t)(metres * 4294967296.0); }

// Degrees of a heading, 0 to 360, counter-clockwise from +x.
static inline double compass_degrees(uint32_t heading) { return heading * (360.0 / 4294967296.0); }

// Least height of the cameras above the floor that can be known, metres.
#define COMPASS_LEAST_CAMERA_HEIGHT_M 0.55

// Largest height of the cameras above the floor that can be known, metres.
#define COMPASS_MOST_CAMERA_HEIGHT_M 2.4

// Directions of a scan: direction j looks along heading + j degrees, counter-clockwise.
#define COMPASS_BINS 360

// Millimetres in a step of a range.
#define COMPASS_STEP_MM 20

// Most poses of a fix: the best and its alternatives.
#define COMPASS_MAX_POSES 10

// Most layers of floors: a floor of a site has one or two, the plan as drawn and its structure.
#define COMPASS_MAX_LAYERS 16

// Most pixels of an image.
#define COMPASS_MAX_PIXELS 67108864

// Bytes of a floor's name with the zero behind it, UTF-8.
#define COMPASS_NAME_BYTES 24

// Alignment of the memory, bytes.
#define COMPASS_ALIGNMENT 8

// Bytes of memory for frames of 368 x 360 pixels with the settings of COMPASS_PRESET_BOARD, on any machine.
#define COMPASS_MEMORY_368X360 446000

// Version of this header: major times 10000 + minor times 100 + patch.
#define COMPASS_VERSION 100

// What became of a call. `compass_last_error` says more about the last one that failed.
enum CompassStatus
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // The call succeeded.
  COMPASS_STATUS_OK = 0,
  // A pointer is null that must not be.
  COMPASS_STATUS_NULL = 1,
  // The pointer is no Compass: compass_new did not make it, compass_end ended it, or its memory was overwritten or moved.
  COMPASS_STATUS_HANDLE = 2,
  // The memory is not aligned to COMPASS_ALIGNMENT bytes, or another pointer not to its type.
  COMPASS_STATUS_ALIGNMENT = 3,
  // The memory is too short: see compass_memory_bytes.
  COMPASS_STATUS_MEMORY = 4,
  // A setting lies outside its range, or the settings were not made by compass_settings.
  COMPASS_STATUS_SETTINGS = 5,
  // The bytes are no site file, or a damaged one.
  COMPASS_STATUS_SITE = 6,
  // The sites have more than COMPASS_MAX_LAYERS layers.
  COMPASS_STATUS_LAYERS = 7,
  // The camera number is above 1, or the numbers make no lens, no image size or no rotation.
  COMPASS_STATUS_CAMERA = 8,
  // A frame is missing, is of a camera that was not set, or has another size than its camera.
  COMPASS_STATUS_FRAME = 9,
  // Up vector or height is not finite or outside its range, or the prior does not say what is known.
  COMPASS_STATUS_PRIOR = 10,
  // A step before this one is missing: cameras and site, then see, then locate, then track once.
  COMPASS_STATUS_ORDER = 11,
  // The frames show too few vertical lines, or no sky where the prior leaves the side open: up is unknown.
  COMPASS_STATUS_UP = 12,
  // The up vector lies along the optical axis of camera 0, which leaves no heading.
  COMPASS_STATUS_AXIS = 13,
  // No pose was found.
  COMPASS_STATUS_NOWHERE = 14,
  // Seconds or motion are not finite, or seconds are negative.
  COMPASS_STATUS_MOTION = 15,
  // No site that was added has this floor and layer.
  COMPASS_STATUS_FLOOR = 16,
  // The position lies outside the plan.
  COMPASS_STATUS_OUTSIDE = 17,
  // The position lies inside a wall or glazing.
  COMPASS_STATUS_OCCUPIED = 18,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassStatus CompassStatus;
#else
typedef int32_t CompassStatus;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Where settings start.
enum CompassPreset
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // For a microcontroller with 512 KiB of RAM, and frames of 368 x 360 pixels.
  COMPASS_PRESET_BOARD = 1,
  // For a computer: 9.2 MB of memory for frames of 1472 x 1440 pixels.
  COMPASS_PRESET_FULL = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassPreset CompassPreset;
#else
typedef int32_t CompassPreset;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// Whether frames are smoothed where windows are sought.
enum CompassSmoothing
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Frames are taken as they are.
  COMPASS_SMOOTHING_OFF = 0,
  // Each stage smooths its frames anew: more work, no more memory.
  COMPASS_SMOOTHING_AGAIN = 1,
  // Smoothed frames are kept: a byte of memory a pixel. The same poses as with Again.
  COMPASS_SMOOTHING_KEPT = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassSmoothing CompassSmoothing;
#else
typedef int32_t CompassSmoothing;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What is known of the upward direction. There is no 0: a prior that says nothing is refused.
enum CompassUpKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Unknown but for camera 0 being upright or upside down, to about 35 degrees: vertical lines tell the axis, and the
  // sky in the windows the side.
  COMPASS_UP_KIND_UNKNOWN = 1,
  // Near `up`, to about 35 degrees: the mounting, or an accelerometer. Vertical lines tell the rest.
  COMPASS_UP_KIND_NEAR = 2,
  // Exactly `up`, to a degree or better: no vertical lines are needed.
  COMPASS_UP_KIND_EXACT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassUpKind CompassUpKind;
#else
typedef int32_t CompassUpKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What is known of the heights of camera and ceiling. There is no 0: a prior that says nothing is refused.
enum CompassHeightKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Unknown: both are searched, which takes 2 to 5 times as long in all.
  COMPASS_HEIGHT_KIND_UNKNOWN = 1,
  // The cameras' height above the floor is `camera_height_m`.
  COMPASS_HEIGHT_KIND_CAMERA = 2,
  // Both are `heights`, as from an earlier fix on this floor.
  COMPASS_HEIGHT_KIND_BOTH = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassHeightKind CompassHeightKind;
#else
typedef int32_t CompassHeightKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// What is known of the pose: `Anywhere`, or a sum of the others. There is no 0: a prior that says nothing is refused.
enum CompassPlaceKind
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Unknown: all floors are searched at all headings.
  COMPASS_PLACE_KIND_ANYWHERE = 1,
  // The position is at most `near_radius_m` from `near_x`, `near_y`.
  COMPASS_PLACE_KIND_NEAR = 2,
  // The heading is at most `heading_width` from `heading`, to either side.
  COMPASS_PLACE_KIND_HEADING = 4,
  // The pose is on `floor`.
  COMPASS_PLACE_KIND_FLOOR = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassPlaceKind CompassPlaceKind;
#else
typedef int32_t CompassPlaceKind;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// The formula of a lens.
enum CompassLensModel
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
  // Kannala and Brandt: "equidistant" in Kalibr, "fisheye" in OpenCV.
  COMPASS_LENS_MODEL_KANNALA_BRANDT = 1,
  // Enhanced unified camera model: "eucm" in Kalibr.
  COMPASS_LENS_MODEL_EUCM = 2,
  // Double sphere model: "ds" in Kalibr.
  COMPASS_LENS_MODEL_DOUBLE_SPHERE = 3,
  // Unified omnidirectional model with distortion: "omni" with "radtan" or "none" in Kalibr; with xi 0 its "pinhole" with
  // these.
  COMPASS_LENS_MODEL_OMNI = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum CompassLensModel CompassLensModel;
#else
typedef int32_t CompassLensModel;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

// A Compass, in memory that the caller lends.
typedef struct Compass Compass;

// Work of the search.
typedef struct {
  // Poses that are refined, 8 to 48.
  uint8_t refined_poses;
  // Poses of these that are refined to the end, 1 to 48: the others are right to a decimetre or two.
  uint8_t refined_fully;
  // Stride of the rays that coarse refinement casts, 4 to 36.
  uint8_t rays;
} CompassEffort;

// How the pipeline works. Start from compass_settings and change what differs.
typedef struct {
  // The preset that the fields come from: of what has no field here its values hold.
  CompassPreset preset;
  // Whether frames are smoothed.
  CompassSmoothing smoothing;
  // Segments kept of each frame, 1 to 65536.
  uint32_t segments;
  // Near-vertical segments of both frames, 1 to 65536.
  uint32_t vertical_segments;
  // Pairs of edges that are scored as windows, 1 to 65536.
  uint32_t boxes;
  // Windows all around, 1 to 65536.
  uint32_t windows;
  // Poses that the search keeps for refinement, 64 to 4096.
  uint32_t pool;
  // Headings at which candidates are scored: 40 or 90.
  uint16_t headings;
  // Finest cells of the panorama, in a degree: 2 or 4. Lenses of fewer than 3 pixels a degree have 2 in any case.
  uint8_t panorama_per_degree;
  // 1 if segments are sought within 95 degrees of the optical axis alone (a bit of memory a pixel), else 0.
  uint8_t lens_field_mask;
  // Work of the search where the camera's height is unknown.
  CompassEffort effort;
  // Work of the search where it is known.
  CompassEffort effort_at_known_height;
} CompassSettings;

// Parameters of COMPASS_LENS_MODEL_KANNALA_BRANDT.
typedef struct {
  // Coefficients k1 to k4.
  float k[4];
} CompassKannalaBrandt;

// Parameters of COMPASS_LENS_MODEL_EUCM.
typedef struct {
  // Share of the sphere in the model, 0 to 1.
  float alpha;
  // Squared ratio of the ellipsoid's axes, above 0.
  float beta;
} CompassEucm;

// Parameters of COMPASS_LENS_MODEL_DOUBLE_SPHERE.
typedef struct {
  // Distance of the two centres, above -1, at most 1.
  float xi;
  // Share of the second sphere in the model, 0 to 1.
  float alpha;
} CompassDoubleSphere;

// Parameters of COMPASS_LENS_MODEL_OMNI.
typedef struct {
  // Distance of the sphere's centre from that of the projection, from 0 up: 0 is a pinhole.
  float xi;
  // Radial coefficients k1 to k3, of the radius to the powers of 2, 4 and 6; Kalibr has no k3.
  float k[3];
  // Tangential coefficients p1 and p2.
  float p[2];
} CompassOmni;

// Parameters of the lens: those of its model.
typedef union {
  // Of COMPASS_LENS_MODEL_KANNALA_BRANDT.
  CompassKannalaBrandt kannala_brandt;
  // Of COMPASS_LENS_MODEL_EUCM.
  CompassEucm eucm;
  // Of COMPASS_LENS_MODEL_DOUBLE_SPHERE.
  CompassDoubleSphere double_sphere;
  // Of COMPASS_LENS_MODEL_OMNI.
  CompassOmni omni;
} CompassLensParameters;

// A lens; the centre of the top left pixel is (0, 0).
typedef struct {
  // Which of the parameters hold.
  CompassLensModel model;
  // Focal length along x, pixels.
  float fx;
  // Focal length along y, pixels.
  float fy;
  // Principal point along x, pixels.
  float cx;
  // Principal point along y, pixels.
  float cy;
  // Parameters of the model.
  CompassLensParameters parameters;
} CompassLens;

// A fisheye camera. Axes are x right, y down, z forward.
typedef struct {
  // Its lens.
  CompassLens lens;
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
typedef struct {
  // Gray levels, row by row without gaps.
  const uint8_t *gray;
  // Bytes of them: width times height.
  size_t gray_bytes;
  // Exclusion mask, one bit a pixel, set where the image says nothing of the building (the robot's own parts in front of a
  // window): rows of (width + 7) / 8 bytes, the first pixel in the lowest bit. Null if nothing is to be left out.
  const uint8_t *excluded;
  // Bytes of it: rows times height; 0 without a mask.
  size_t excluded_bytes;
  // Pixels along x: that of the camera.
  uint16_t width;
  // Pixels along y: that of the camera.
  uint16_t height;
} CompassFrame;

// Heights as the search counts them, in steps of 6.3 %: copy them from a fix.
typedef struct {
  // Height of the cameras above the floor, 0 for 1.5 m.
  int8_t camera;
  // By how many steps the ceiling is higher above the cameras than the floor is below them.
  int8_t ceiling;
} CompassHeights;

// What is known before anything is seen.
typedef struct {
  // What `up` says: read by compass_see.
  CompassUpKind up_kind;
  // Upward direction in the axes of camera 0, of any length: {0, -1, 0} if it is upright, {0, 1, 0} upside down.
  float up[3];
  // Which of the fields below hold: read by compass_locate.
  CompassHeightKind height_kind;
  // Height of the cameras above the floor, metres, COMPASS_LEAST_CAMERA_HEIGHT_M to COMPASS_MOST_CAMERA_HEIGHT_M.
  float camera_height_m;
  // Heights of camera and ceiling.
  CompassHeights heights;
  // Which of the fields below hold: read by compass_locate. They restrict the search, so be generous: poses elsewhere are
  // not found.
  CompassPlaceKind place_kind;
  // Map coordinate in 1/2^32 m: see compass_coordinate.
  int64_t near_x;
  // Map coordinate in 1/2^32 m: see compass_coordinate.
  int64_t near_y;
  // Largest distance from there, metres, above 0.
  float near_radius_m;
  // Heading of camera 0 in 1/2^32 turn, counter-clockwise from +x.
  uint32_t heading;
  // Largest angle from it to either side, in 1/2^32 turn, above 0.
  uint32_t heading_width;
  // Number of the floor, in the order in which the sites have them and were added.
  uint8_t floor;
} CompassPrior;

// A pose on a floor.
typedef struct {
  // Map coordinate in 1/2^32 m: see compass_metres.
  int64_t x;
  // Map coordinate in 1/2^32 m: see compass_metres.
  int64_t y;
  // Heading of camera 0 in 1/2^32 turn, counter-clockwise from +x: see compass_degrees.
  uint32_t heading;
  // Log-likelihood ratio against "nothing known", 1/16 nat.
  int32_t score;
  // Number of the floor, in the order in which the sites have them and were added.
  uint8_t floor;
  // Which layer of the floor fits best: 0 the plan as drawn, 1 its structure alone.
  uint8_t layer;
  // Name of the floor, with a zero behind it.
  char floor_name[COMPASS_NAME_BYTES];
} CompassPose;

// Where the cameras are.
typedef struct {
  // The best pose and its alternatives, best first.
  CompassPose poses[COMPASS_MAX_POSES];
  // Of each pose the covariance of its error if it is right, of x, y and heading, row by row: m2, m rad and rad2.
  float covariances[COMPASS_MAX_POSES][9];
  // Number of poses; 0 if none was found.
  uint32_t count;
  // Probability that the best is within 1 m of the true one, 0 to 1.
  float probability;
  // Height of the cameras above the floor, metres, to 3 %: that given, or that found.
  float camera_height_m;
  // Height of the ceiling above the floor, metres, to 3 % of the part above the cameras.
  float ceiling_height_m;
  // Both as the search counts them: for the next prior.
  CompassHeights heights;
} CompassFix;

// How the cameras moved since the frames that were tracked before, in the level axes they had then: forward is where
// camera 0 looked.
typedef struct {
  // Metres.
  float forward_m;
  // Metres.
  float left_m;
  // Radians, counter-clockwise.
  float turn;
} CompassMotion;

// What is believed after a sequence of frames.
typedef struct {
  // The likeliest pose.
  CompassPose pose;
  // Its probability among the poses that are believed possible, 0 to 1; 0 if there is none.
  float probability;
  // Root mean square distance of the possible poses on its floor from it, metres.
  float spread_m;
} CompassEstimate;

// Range and hit type all around.
typedef struct {
  // Ranges in steps of COMPASS_STEP_MM, 1 to 1500.
  uint16_t steps[COMPASS_BINS];
  // What is there: 0 nothing within 30 m, 1 glazing, 2 a wall.
  uint8_t hit[COMPASS_BINS];
} CompassScan;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

// Version of the library: COMPASS_VERSION of the header that it was built with.
uint32_t compass_version(void);

// What a status means: a sentence that needs no freeing, for any number.
const char *compass_status_text(CompassStatus status);

// Settings to start from; for a number that is no preset, settings that are refused.
CompassSettings compass_settings(CompassPreset preset);

// Bytes of memory for two cameras with images of at most this size. 0 if settings are null or refused, or an image has
// more than COMPASS_MAX_PIXELS.
size_t compass_memory_bytes(uint16_t width,
                            uint16_t height,
                            const CompassSettings *settings);

// Begins: a Compass in this memory, which it uses until compass_end. COMPASS_ALIGNMENT says how the memory is aligned,
// compass_memory_bytes how much it takes. `*compass` is null on failure. MEMORY,
// SETTINGS.
CompassStatus compass_new(void *memory,
                          size_t bytes,
                          const CompassSettings *settings,
                          Compass **compass);

// Ends: the memory is the caller's again, and later calls are refused as long as it is not lent anew.
CompassStatus compass_end(Compass *compass);

// Says why the last call with this Compass failed, with names and numbers: which camera, which sizes, how many bytes are
// missing. Writes at most `bytes` bytes with the zero at the end, and returns the length of the whole sentence without it;
// 0 if the last call succeeded. `buffer` may be null if `bytes` is 0.
size_t compass_last_error(const Compass *compass,
                          char *buffer,
                          size_t bytes);

// Adds all layers of all floors of a site file (`compass map build`), which is read in place: it must stay as it is until
// compass_end. Checksums are compared, which reads the file twice. On failure none is added. Frames must be seen anew. SITE,
// LAYERS.
CompassStatus compass_add_site(Compass *compass,
                               const void *site,
                               size_t bytes);

// Sets a camera, number 0 or 1; null takes it away. If it is refused the former stays. Frames must be seen anew.
// CAMERA, MEMORY.
CompassStatus compass_set_camera(Compass *compass,
                                 uint8_t number,
                                 const CompassCamera *camera);

// Looks at the frames of one moment: those of all cameras that were set, null for a camera that was not. They are not used
// after the call. Of the prior `up_kind` and `up` are read. FRAME, PRIOR, ORDER, UP, AXIS.
CompassStatus compass_see(Compass *compass,
                          const CompassFrame *frame_0,
                          const CompassFrame *frame_1,
                          const CompassPrior *prior);

// Finds the pose that explains best what was seen, over all layers. May be called again with another prior, of which all
// but `up_kind` and `up` are read. On failure `fix->count` is 0. PRIOR, ORDER, NOWHERE.
CompassStatus compass_locate(Compass *compass,
                             const CompassPrior *prior,
                             CompassFix *fix);

// Takes the frames that were just located into the belief over the sequence, once, also after NOWHERE: `seconds` since the
// frames tracked before, 0 for the first; `motion` as measured since then, or null. On failure `estimate->probability` is
// 0. ORDER, MOTION, NOWHERE.
CompassStatus compass_track(Compass *compass,
                            float seconds,
                            const CompassMotion *motion,
                            CompassEstimate *estimate);

// Forgets the sequence: the next frames that are tracked are the first.
CompassStatus compass_forget(Compass *compass);

// What surrounds a pose in its plan, cast with 360 rays: floor, layer, x, y and heading of the pose are read. FLOOR,
// OUTSIDE, OCCUPIED.
CompassStatus compass_describe(Compass *compass,
                               const CompassPose *pose,
                               CompassScan *scan);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* COMPASS_H */
