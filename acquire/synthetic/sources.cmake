list(APPEND sources
  synthetic/analytic_scene.cpp synthetic/camera_paths.cpp synthetic/mesh_scene.cpp synthetic/noise.cpp
  synthetic/render.cpp synthetic/scene_catalogue.cpp synthetic/solid.cpp synthetic/surface_error.cpp
  synthetic/surface_samples.cpp synthetic/synthetic_source.cpp synthetic/texture.cpp synthetic/triangle_bvh.cpp
  synthetic/truth_files.cpp synthetic/write_recording.cpp)
