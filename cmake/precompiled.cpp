// Nothing but the precompiled headers: cmake/Targets.cmake.
