#include <utility>

#include "app/config/config_keys.h"

namespace scanknit {
namespace {

using namespace config_keys;

ConfigKey crop_limit(const char* name, std::size_t axis, bool is_high) {
  ConfigKey limit =
      describe(ConfigType::kLength,
               {name, "m",
                is_high ? "Upper limit of the crop box on this axis, in the recording's world. auto: no limit."
                        : "Lower limit of the crop box on this axis, in the recording's world. auto: no limit."},
               {-1e4, 1e4});
  bind_optional<double>(
      limit,
      [ axis, is_high ](auto& c) -> auto& { return is_high ? c.finish.crop.high_m[axis] : c.finish.crop.low_m[axis]; });
  return limit;
}

std::vector<ConfigKey> closing_keys() {
  ConfigKey clearance = describe(
      ConfigType::kLength,
      {"finish.ground_clearance", "m", "How far above its plane the table or the floor is cut. auto: two voxels."},
      {0, 1});
  bind_optional<double>(
      clearance, [](auto& c) -> auto& { return c.finish.ground_clearance_m; });
  return {
      choice<GroundMode>(
          {"finish.ground", "",
           "The table or the floor, the largest plane across the world's up (RANSAC). keep; remove: cut away, so that "
           "what stood on it is open below; cap: cut away and closed by a plane, which finish.watertight: full draws."},
          {{"keep", GroundMode::kKeep}, {"remove", GroundMode::kRemove}, {"cap", GroundMode::kCap}},
          [](auto& c) -> auto& { return c.finish.ground; }),
      std::move(clearance),
      choice<Watertight>(
          {"finish.watertight", "",
           "Holes are closed in the volume, before the surface is extracted, by the smallest surface that agrees with "
           "all that was seen. small: holes up to finish.max_hole; full: all, so that the mesh is closed."},
          {{"off", Watertight::kOff}, {"small", Watertight::kSmall}, {"full", Watertight::kFull}},
          [](auto& c) -> auto& { return c.finish.watertight; }),
      length(
          {"finish.max_hole", "",
           "finish.watertight: small closes holes up to this size, the diagonal of the patch's bounding box."},
          {1e-4, 100}, [](auto& c) -> auto& { return c.finish.max_hole_m; }),
      optional_choice<Rgb8>(
          {"finish.mark_invented", "",
           "Colour, in the mesh files, of the surface that closes holes. auto: the colour of the surface beside it; "
           "grey if that has none."},
          {{"magenta", Rgb8{255, 0, 255}},
           {"red", Rgb8{255, 0, 0}},
           {"green", Rgb8{0, 255, 0}},
           {"blue", Rgb8{0, 0, 255}},
           {"grey", Rgb8{128, 128, 128}}},
          [](auto& c) -> auto& { return c.finish.invented_colour; }),
  };
}

std::vector<ConfigKey> mesh_keys() {
  ConfigKey triangles = describe(
      ConfigType::kInteger,
      {"finish.triangles", "triangles", "The mesh is simplified to about this many triangles. auto: it keeps all."},
      {4, 1e9});
  bind_optional<std::int64_t>(
      triangles, [](auto& c) -> auto& { return c.finish.triangles; });
  ConfigKey error =
      describe(ConfigType::kLength,
               {"finish.simplify_error", "m",
                "Simplification moves the surface by at most this much (quadric error); it stops earlier at "
                "finish.triangles. auto: no limit; without finish.triangles the mesh is not simplified."},
               {1e-6, 1});
  bind_optional<double>(
      error, [](auto& c) -> auto& { return c.finish.simplify_error_m; });
  return {
      choice<bool>(
          {"finish.crumbs", "",
           "Separate pieces that float and that few frames confirm are noise. remove: they are left out and counted; a "
           "piece that several frames saw stays, however small it is. keep: all stay."},
          {{"remove", true}, {"keep", false}}, [](auto& c) -> auto& { return c.finish.drops_crumbs; }),
      number(
          {"finish.min_piece_share", "",
           "Separate pieces whose area is a smaller share of the largest one's are left out; 0: keep all."},
          {0, 1}, [](auto& c) -> auto& { return c.finish.min_piece_share; }),
      length(
          {"finish.min_piece_size", "",
           "Separate pieces whose bounding box has a shorter diagonal are left out; 0: keep all."},
          {0, 100}, [](auto& c) -> auto& { return c.finish.min_piece_size_m; }),
      integer(
          {"finish.smooth", "steps",
           "How many times the mesh is smoothed, without shrinking (Taubin 1995); 0: not at all."},
          {0, 1000}, [](auto& c) -> auto& { return c.finish.smooth_steps; }),
      std::move(triangles),
      std::move(error),
      choice<UpMode>(
          {"finish.up", "",
           "Which way is up in the files. world: as the recording or export.world_up says; ground: across the table "
           "or the floor that is found."},
          {{"world", UpMode::kWorld}, {"ground", UpMode::kGround}}, [](auto& c) -> auto& { return c.finish.up; }),
      choice<OriginMode>(
          {"finish.origin", "",
           "keep: the recording's; ground: the mesh stands on the ground, its bounding box centred over the origin."},
          {{"keep", OriginMode::kKeep}, {"ground", OriginMode::kGround}},
          [](auto& c) -> auto& { return c.finish.origin; }),
  };
}

}  // namespace

std::vector<ConfigKey> finish_keys() {
  std::vector<ConfigKey> keys = {
      crop_limit("finish.crop.min_x", 0, false), crop_limit("finish.crop.min_y", 1, false),
      crop_limit("finish.crop.min_z", 2, false), crop_limit("finish.crop.max_x", 0, true),
      crop_limit("finish.crop.max_y", 1, true),  crop_limit("finish.crop.max_z", 2, true),
  };
  for (auto part : {closing_keys(), mesh_keys()}) std::move(part.begin(), part.end(), std::back_inserter(keys));
  return keys;
}

}  // namespace scanknit
