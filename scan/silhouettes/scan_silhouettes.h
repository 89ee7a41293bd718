// scan_silhouettes: from pictures with masks to a finished mesh.
#pragma once

#include <stop_token>

#include "scan/scan_job.h"
#include "scan/scan_observer.h"
#include "scan/scan_result.h"

namespace scanknit {

/// What scan_recording() does where acquire.geometry is silhouettes: reads the pictures of a folder, carves the visual
/// hull, paints it, and writes all files of the job. Pictures that cannot be read, or whose mask says nothing, are
/// dropped. Pictures without poses are of a thing on a turntable (turntable.enabled), whose axis is found. Unless the
/// job asks for fusion.voxel_size, voxels are as large as the pixels are on the thing, but at most 400 along its
/// longest side. ScanResult::outcome: kOutput before any work; kInput; kTooLittle when stopped before the mesh, or with
/// fewer than two pictures; kBudget; kMesh; kUsage and kConfig for options that do not apply.
[[nodiscard]] ScanResult scan_silhouettes(const ScanJob& job, ScanObserver& observer, std::stop_token stop = {});

}  // namespace scanknit
