// VolumeHeader: what a volume's file says about its samples.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace scanknit {

struct VolumeHeader {
  Eigen::Vector3i dims = Eigen::Vector3i::Zero();  ///< samples along i (fastest in the file), j, k; each >= 2
  /// Sample (i,j,k) to the file's own coordinates and unit: its spacing, origin and directions, never converted between
  /// RAS and LPS. Invertible; the determinant may be negative.
  Eigen::Affine3d T_file_index = Eigen::Affine3d::Identity();
  double metres_per_unit = 1e-3;      ///< millimetres unless the file says otherwise
  std::string format;                 ///< "NRRD", "MetaImage", "NIfTI", "DICOM", "image stack" or "raw"
  std::string sample_type;            ///< in the file: "int16", "float" ... (sample_type.h)
  std::vector<std::string> warnings;  ///< for the person: what was assumed, chosen or left out
};

}  // namespace scanknit
