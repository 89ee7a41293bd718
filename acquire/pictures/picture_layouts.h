// The layouts of pictures without depth. One .cpp each.
#pragma once

#include "acquire/pictures/picture_set.h"
#include "acquire/replay/folder.h"

namespace scanknit {

// fits_*: true if the folder has this layout. list_*: its pictures; masks only where the layout's file names them.
// Errors (kInput) name the file. Neither opens a picture, but list_transforms_pictures()
// the first one, if its size is not stated.

[[nodiscard]] bool fits_transforms_pictures(const Folder& folder);
[[nodiscard]] Result<PictureSet> list_transforms_pictures(const Folder& folder, const AcquireConfig& config);

/// `folder`: that of the text model itself, or one that has it in sparse/0 or sparse.
[[nodiscard]] bool fits_colmap_pictures(const Folder& folder);
[[nodiscard]] Result<PictureSet> list_colmap_pictures(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_par_pictures(const Folder& folder);
[[nodiscard]] Result<PictureSet> list_par_pictures(const Folder& folder, const AcquireConfig& config);

[[nodiscard]] bool fits_folder_pictures(const Folder& folder);
[[nodiscard]] Result<PictureSet> list_folder_pictures(const Folder& folder, const AcquireConfig& config);

/// Without poses: one camera, before which a thing turned.
[[nodiscard]] bool fits_still_camera_pictures(const Folder& folder);
[[nodiscard]] Result<PictureSet> list_still_camera_pictures(const Folder& folder, const AcquireConfig& config);

}  // namespace scanknit
