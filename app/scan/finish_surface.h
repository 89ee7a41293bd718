// From a volume to the surface that is written: extraction, and what `finish:` asks for before and after it.
#pragma once

#include <cstddef>
#include <stop_token>
#include <string>

#include "app/config/config.h"
#include "app/terminal/console.h"
#include "core/axes.h"
#include "core/field_view.h"
#include "core/pose.h"
#include "core/result.h"
#include "export/report/report.h"
#include "extract/extract_surface.h"

namespace scanknit {

struct FinishedSurface {
  Surface surface;
  Pose T_mesh_world = Pose::Identity();  ///< from the volume's world to where the mesh stands
};

/// What the report says of finishing no longer holds, its warnings neither: another mesh takes the place of that one.
void forget_finish(RunReport& report);

/// Extracts the surface of a volume and finishes it; without `finish:` it is extract_surface(). A step that cannot be
/// done is left out, with the reason in report.finish and among the warnings: a scan is never lost. `world_up` is the
/// way up unless export.world_up says otherwise. When `stop` is asked for in the meantime, the steps that are left are
/// not done, with that for their reason; a stop before is how a scan ends, and changes nothing. Errors:
/// extract_surface()'s; kConfig for steps that make no sense together or for this volume.
[[nodiscard]] Result<FinishedSurface> finished_surface(const FieldView& view, const Config& config, UpAxis world_up,
                                                       RunReport& report, const std::stop_token& stop = {});

/// The same for a mesh that was extracted from a volume without distances, in units of `metres_per_unit`: steps that
/// need distances are errors (kConfig).
[[nodiscard]] Result<FinishedSurface> finished_mesh(Surface surface, double metres_per_unit, const Config& config,
                                                    UpAxis world_up, RunReport& report,
                                                    const std::stop_token& stop = {});

/// Says the warnings that `report` has from `first` on, such as those of finishing.
void say_warnings(const RunReport& report, std::size_t first, Console& console);

/// kConfig if anything is to be finished: the mesh never is in memory as a whole.
[[nodiscard]] Result<void> refuse_to_finish_streamed(const FinishConfig& config);

/// A line for each step, for people; empty without any.
[[nodiscard]] std::string finish_text(const RunReport& report);

}  // namespace scanknit
