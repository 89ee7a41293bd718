scanknit_test(test_synthetic
  SOURCES test_synthetic_noise.cpp test_synthetic_recording.cpp test_synthetic_render.cpp test_synthetic_scenes.cpp
          test_synthetic_surface_error.cpp
  LIBRARIES ScanKnit::acquire ${OpenCV_LIBS} nlohmann_json::nlohmann_json TBB::tbb
  LABELS acquire)
target_compile_definitions(test_synthetic PRIVATE SCANKNIT_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
