scanknit_test(test_acquire_replay
  SOURCES
    test_filter_depth.cpp
    test_filter_normals.cpp
    test_pcl_frames.cpp
    test_replay_bad_frames.cpp
    test_replay_layouts.cpp
    test_replay_open.cpp
    test_replay_pictures.cpp
    test_replay_recordings.cpp
    test_replay_support.cpp
    test_replay_tum.cpp
  LIBRARIES ScanKnit::acquire ${OpenCV_LIBS} scanknit_pcl TBB::tbb
  LABELS acquire)
target_compile_definitions(test_acquire_replay PRIVATE SCANKNIT_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
