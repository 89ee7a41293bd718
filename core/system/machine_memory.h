// How much memory the machine has, or the container that the process runs in.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

namespace scanknit {

/// Where the kernel tells of memory. Tests have folders of their own.
struct KernelFolders {
  std::filesystem::path processes = "/proc", groups = "/sys/fs/cgroup";
};

/// The least of: the machine's memory; what a control group that the process is in, or one round it, may take
/// (`memory.max`; of version 1 `memory.limit_in_bytes`); the process's limit of addresses (`ulimit -v`). MiB, rounded
/// down. Nothing: the kernel does not say how much memory there is.
[[nodiscard]] std::optional<std::size_t> machine_memory_mib(const KernelFolders& folders = {});

/// What a command takes of that unless the user says otherwise (fusion.memory_budget: auto): half, between 128 MiB and
/// 4 GiB; 4 GiB if the memory is not known.
[[nodiscard]] std::size_t default_memory_budget_mib(std::optional<std::size_t> machine_mib);

}  // namespace scanknit
