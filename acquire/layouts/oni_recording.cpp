// Recordings of OpenNI 1 and 2: Xtion, Carmine, Kinect, and whatever NiViewer records.
#include <memory>
#include <utility>

#include "acquire/field_of_view.h"
#include "acquire/layouts/oni_file.h"
#include "acquire/raw/raw_recording.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

std::vector<RawStamp> stamps_of(const OniStream& stream) {
  std::vector<RawStamp> stamps;
  for (const OniPicture& picture : stream.pictures) {
    stamps.push_back({picture.number, static_cast<std::int64_t>(picture.time_us) * 1000});
  }
  return stamps;
}

// Without intrinsics where the file does not state a field of view.
CameraModel camera_of(const OniStream& stream) {
  const auto known =
      intrinsics_of_view(stream.profile.width, stream.profile.height, stream.view_x_rad, stream.view_y_rad);
  return {.intrinsics = known.value_or(CameraIntrinsics{})};
}

}  // namespace

bool fits_oni(const RandomAccess& file) {
  return is_oni(file);
}

Result<Recording> index_oni(std::unique_ptr<RandomAccess> access, const std::filesystem::path& path,
                            const AcquireConfig& config) {
  auto opened = OniFile::open(std::move(access), config.limits);
  if (!opened) return located(opened.error(), path);
  const auto file = std::make_shared<const OniFile>(*std::move(opened));
  RawRecording raw{.format = "oni", .file = path};
  raw.calibration.depth = camera_of(file->depth());  // without a colour camera, colour is taken to be registered
  raw.calibration.depth_unit_m = file->depth().depth_unit_m;
  raw.depth = stamps_of(file->depth());
  if (file->colour()) raw.colour = stamps_of(*file->colour());
  if (file->fault()) raw.warnings.push_back("the recording is torn: " + *file->fault() + ". What came before is read");
  raw.read = [file](StreamKind kind, std::size_t index) { return file->read(kind, index); };
  return index_raw_recording(std::move(raw), config);
}

}  // namespace scanknit
