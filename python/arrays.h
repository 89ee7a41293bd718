// NumPy arrays and our own types. What does not fit is refused by name: a TypeError for the kind of number, a
// ValueError for the shape.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include "core/camera.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/pose.h"

namespace scanknit {

/// (H, W): float32 in metres, or uint16 in `units_per_metre`. What is not finite and above 0 becomes 0, "no return".
[[nodiscard]] DepthImage depth_image(const pybind11::array& depth, double units_per_metre);

/// (H, W, 3) uint8.
[[nodiscard]] ColourImage colour_image(const pybind11::array& colour);

/// fx, fy, cx, cy or a 3 x 3 matrix, of pictures of this size. `name` is the argument's.
[[nodiscard]] CameraIntrinsics intrinsics_of(const pybind11::object& given, int width, int height, const char* name);

/// A 4 x 4 matrix. A Failure for one that is not finite or not rigid.
[[nodiscard]] Pose pose_of(const pybind11::object& given, const char* name);

[[nodiscard]] pybind11::array_t<double> matrix_of(const Pose& pose);
[[nodiscard]] pybind11::tuple tuple_of(const CameraIntrinsics& intrinsics);

}  // namespace scanknit
