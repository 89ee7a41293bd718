#include "app/cli/cli_align.h"

#include <CLI/CLI.hpp>

namespace scanknit {

void add_align_options(CLI::App& command, AlignArguments& align) {
  command
      .add_option("scans", align.request.inputs,
                  "Recordings, range scans (.ply .ply.gz .pcd .ptx), a list of them with poses (.conf), meshes, point "
                  "clouds with normals")
      ->required()
      ->type_name("SCAN...");
  command
      .add_option(
          "--initial", align.request.known.initial,
          "Approximate poses of scans: lines of SCAN tx ty tz qx qy qz qw, or SCAN and a 4x4 matrix row by row; "
          "SCAN is its number, from 1, or its file")
      ->type_name("FILE");
  command
      .add_option("--markers", align.request.known.markers,
                  "Points that several scans have in common: lines of SCAN MARKER x y z, metres in the scan's frame")
      ->type_name("FILE");
  command.add_flag("--refine", align.request.known.wants_refinement,
                   "Correct the poses that a .conf or a PTX gives; default: they are taken as they are");
  command.add_option("--points", align.request.points, "Write the points of all scans here, in one frame")
      ->type_name("FILE.ply|.pcd");
}

}  // namespace scanknit
