# What makes errors harder to exploit, in optimised builds; tests/hardening reads it out of what is installed.
include(CheckPIESupported)
check_pie_supported(LANGUAGES CXX)  # executables are linked as such, too

# All functions of other libraries are found when a file is loaded, and then nothing can change where calls go.
add_link_options("$<$<CONFIG:Release,RelWithDebInfo,MinSizeRel>:-Wl,-z,relro,-z,now,-z,noexecstack>")
