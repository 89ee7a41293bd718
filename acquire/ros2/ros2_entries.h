// The frames of a bag of ROS before any of their pictures is read: times, pairs and poses.
#pragma once

#include "acquire/acquire_config.h"
#include "acquire/replay/recording.h"
#include "acquire/ros2/ros2_survey.h"

namespace scanknit {

/// A frame for each depth picture, with the colour picture nearest in time and the depth camera's pose then. Also says
/// in `recording` where the poses come from and which axis of their world points up. `colour` may be null.
void add_ros2_entries(const Ros2Survey& survey, const PictureTopic& depth, const PictureTopic* colour,
                      const BagTopics& wanted, Recording& recording);

}  // namespace scanknit
