// Volumes on disk: TsdfVolume::save and load_volume.
#include <openvdb/io/File.h>
#include <openvdb/io/Stream.h>
#include <openvdb/tree/LeafManager.h>

#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <ostream>
#include <streambuf>
#include <string>

#include "core/files/atomic_file.h"
#include "core/system/try_in_child.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {
namespace {

/// Metadata of the weights: the standard deviation of a view of weight 1, metres.
constexpr const char* kViewSigma = "view_sigma_m";

/// Lets a library that writes to a std::ostream write to an AtomicFile. The first failure is kept and ends the stream.
class AtomicFileBuffer final : public std::streambuf {
 public:
  explicit AtomicFileBuffer(AtomicFile& file) : file_(file) {}
  [[nodiscard]] const Result<void>& status() const { return status_; }

 protected:
  std::streamsize xsputn(const char* text, std::streamsize count) override {
    if (status_) status_ = file_.write(std::string_view(text, static_cast<std::size_t>(count)));
    written_ += status_ ? count : 0;
    return status_ ? count : 0;
  }
  int_type overflow(int_type character) override {
    if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
    const char c = traits_type::to_char_type(character);
    return xsputn(&c, 1) == 1 ? character : traits_type::eof();
  }
  /// OpenVDB asks where it is (tellp), never to go elsewhere.
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    return offset == 0 && from == std::ios_base::cur ? pos_type(written_) : pos_type(off_type(-1));
  }

 private:
  AtomicFile& file_;
  Result<void> status_;
  std::streamoff written_ = 0;
};

Error unreadable(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kInput, "not a readable OpenVDB file: " + what, path.string()};
}

std::string list_names(const openvdb::GridPtrVec& grids) {
  std::string names;
  for (const auto& grid : grids)
    names += (names.empty() ? "" : ", ") + grid->getName() + " (" + grid->valueType() + ")";
  return names.empty() ? "none" : names;
}

/// The grid of this type and name; with an empty name the first of this type.
template <typename Grid>
typename Grid::Ptr find_grid(const openvdb::GridPtrVec& grids, const std::string& name) {
  for (const auto& grid : grids) {
    auto typed = openvdb::gridPtrCast<Grid>(grid);
    if (typed && (name.empty() || grid->getName() == name)) return typed;
  }
  return nullptr;
}

/// The grid in a stock type: every voxel's code decoded.
template <typename Stock, typename Coded, typename Decode>
typename Stock::Ptr in_stock_type(const Coded& coded, const typename Stock::ValueType& background,
                                  const Decode& decode) {
  auto tree = std::make_shared<typename Stock::TreeType>(coded.tree(), background, openvdb::TopologyCopy());
  using StockLeaf = typename Stock::TreeType::LeafNodeType;
  openvdb::tree::LeafManager<typename Stock::TreeType> leaves(*tree);
  leaves.foreach ([&](StockLeaf& leaf, std::size_t) {
    const auto* from = coded.tree().probeConstLeaf(leaf.origin());
    for (openvdb::Index i = 0; i < StockLeaf::SIZE; ++i) leaf.setValueOnly(i, decode(from->getValue(i)));
  });
  auto grid = Stock::create(tree);
  grid->setName(coded.getName());
  grid->setTransform(coded.transform().copy());
  return grid;
}

openvdb::Vec3s floats_of(ColourCode code) {
  if (!has_colour(code)) return openvdb::Vec3s(-1);
  const Rgb8 colour = decode_colour(code);
  return openvdb::Vec3s(colour.r, colour.g, colour.b) / 255.0f;
}

/// OpenVDB believes the counts in a file; these stop it at a damaged one. In a sound one, a leaf without a value is a
/// mask of 64 bytes and takes up to 6.2 kB.
ChildLimits limits_for(std::uintmax_t file_bytes) {
  constexpr std::size_t kAnyFile = std::size_t{256} << 20;
  return {.memory_bytes = kAnyFile + 128 * file_bytes, .seconds = 10 + static_cast<double>(file_bytes) / 2e6};
}

/// Believes every count in the file. Throws std::bad_alloc.
Result<LoadedVolume> read_volume(const std::filesystem::path& path) {
  try {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(/*delayLoad=*/false);
    const openvdb::GridPtrVecPtr grids = file.getGrids();
    LoadedVolume volume;
    volume.field = find_grid<openvdb::FloatGrid>(*grids, "tsdf");
    const bool is_ours = volume.field != nullptr;
    if (!is_ours) volume.field = find_grid<openvdb::FloatGrid>(*grids, "");
    if (!volume.field) {
      return Error{ErrorCode::kInput, "holds no grid of floats; it holds: " + list_names(*grids), path.string()};
    }
    if (is_ours) volume.weight = find_grid<openvdb::FloatGrid>(*grids, "weight");
    volume.colour = find_grid<openvdb::Vec3SGrid>(*grids, "colour");
    volume.is_signed_distance = is_ours || volume.field->getGridClass() == openvdb::GRID_LEVEL_SET;
    return volume;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    return unreadable(path, e.what());
  }
}

}  // namespace

Result<void> TsdfVolume::save(const std::filesystem::path& path, std::optional<double> view_sigma_m) const {
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  AtomicFileBuffer buffer(*file);
  try {
    std::ostream stream(&buffer);
    openvdb::MetaMap metadata;
    metadata.insertMeta("creator", openvdb::StringMetadata("ScanKnit"));
    metadata.insertMeta("unit", openvdb::StringMetadata("metre"));
    metadata.insertMeta("colour_encoding", openvdb::StringMetadata("sRGB, 0 to 1; negative: not seen"));
    const auto weights = in_stock_type<openvdb::FloatGrid>(*weight_, 0.0f, decode_weight);
    if (view_sigma_m) weights->insertMeta(kViewSigma, openvdb::DoubleMetadata(*view_sigma_m));
    const openvdb::GridCPtrVec grids{tsdf_, weights,
                                     in_stock_type<openvdb::Vec3SGrid>(*colour_, openvdb::Vec3s(-1), floats_of)};
    openvdb::io::Stream(stream).write(grids, metadata);
    if (buffer.status() && !stream) return Error{ErrorCode::kOutput, "OpenVDB failed to write", path.string()};
  } catch (const std::bad_alloc&) {
    if (buffer.status()) return Error{ErrorCode::kBudget, "out of memory while the volume was written", path.string()};
  } catch (const std::exception& e) {
    if (buffer.status())
      return Error{ErrorCode::kOutput, std::string("OpenVDB failed to write: ") + e.what(), path.string()};
  }
  if (!buffer.status()) return buffer.status();
  return file->commit();
}

FieldView LoadedVolume::field_view() const {
  FieldView view;
  view.field = field.get();
  view.weight = weight.get();
  view.colour = colour.get();
  view.is_signed_distance = is_signed_distance;
  return view;
}

std::optional<double> LoadedVolume::view_sigma_m() const {
  if (!weight) return std::nullopt;
  const auto stated = weight->getMetadata<openvdb::DoubleMetadata>(kViewSigma);
  if (!stated || !(stated->value() > 0) || !std::isfinite(stated->value())) return std::nullopt;
  return stated->value();
}

Result<LoadedVolume> load_volume(const std::filesystem::path& path) {
  std::error_code code;
  if (!std::filesystem::is_regular_file(path, code)) return Error{ErrorCode::kInput, "no such file", path.string()};
  const auto tried = try_in_child(
      [&] {
        const auto volume = read_volume(path);
        return volume ? Result<void>() : volume.error();
      },
      limits_for(std::filesystem::file_size(path, code)));
  if (!tried) return Error{tried.error().code, tried.error().message, path.string()};
  try {
    return read_volume(path);
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while the volume was read", path.string()};
  }
}

}  // namespace scanknit
