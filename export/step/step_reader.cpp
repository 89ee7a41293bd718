#include "export/step/step_reader.h"

#include "core/system/module.h"
#include "core/system/try_in_child.h"

namespace scanknit {

Result<Mesh> read_step(std::string_view bytes, const Limits& limits, MeshNotes* notes) {
  const auto reader = load_module<StepReader>(
      "step_reader",
      "STEP models need Debian's package scanknit-step, or libocct-data-exchange-dev when ScanKnit is "
      "built; or export the model as STL");
  if (!reader) return Error{ErrorCode::kInput, reader.error().message};
  constexpr std::size_t kAnyModel = std::size_t{1} << 30;
  constexpr std::size_t kByteOfModel = 256;  // entities, shapes and triangles of one byte of text
  const ChildLimits child{.memory_bytes = kAnyModel + kByteOfModel * bytes.size(),
                          .seconds = 10 + static_cast<double>(bytes.size()) / 2e4};
  const auto tried = try_in_child(
      [&]() -> Result<void> {
        const auto mesh = (*reader)->read(bytes, limits, nullptr);
        return mesh ? Result<void>() : mesh.error();
      },
      child);
  if (!tried) return tried.error();
  return (*reader)->read(bytes, limits, notes);
}

}  // namespace scanknit
