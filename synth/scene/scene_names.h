// The scenes that ScanKnit knows by name.
#pragma once

#include <array>
#include <string_view>

namespace scanknit {

inline constexpr std::string_view kBoardSceneName = "calibration_board";

/// The analytic scenes:
///   sphere     radius 0.1 m, alone. Euler characteristic 2.
///   turntable  a figurine of 24 cm with one handle, alone: a closed surface of genus 1, Euler characteristic 0.
///   tower      blocks of 20 cm on each other, alone; Euler characteristic 2. One turn seen from 28 degrees above shows
///              everything except the underside.
///   desk       objects on a desk in a room; the camera goes round it at 3 degrees and 5 cm a frame.
///   plates     plates of 6 to 20 mm standing in a room, seen from 0.6 m to 3 m.
///   room       a furnished room of 5 x 4 m; the camera walks a loop and comes back to where it began.
///   gallery    a corridor of 2 m round a block of 5.8 x 3.8 m: its beginning comes into view again after 26 m only.
///   twins      two corners 8 m apart that look the same in every detail; nothing is seen twice.
///   clutter    a desk with some thirty things, cables, thin legs, glass, and a screen that sends no light back.
///   corridor   18 m long and 1.8 m wide, bare but for doors; the camera walks along it.
///   bare_wall  a wall with one poster at its end; the camera goes along it at 1.2 m.
///   hall       a table with things on it before an open hall: depth from 0.4 to 30 m.
///   cup        a cup of 10 cm, alone, whose handle sends no light back; Euler characteristic 0.
///   calibration_board  a board of 36 x 25 cm for `calibrate camera`, which the camera sees from all sides.
inline constexpr std::array<std::string_view, 14> kSceneNames = {
    "sphere", "turntable", "tower",    "desk",      "plates", "room", "gallery",
    "twins",  "clutter",   "corridor", "bare_wall", "hall",   "cup",  kBoardSceneName};

}  // namespace scanknit
