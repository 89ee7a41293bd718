// Keeps freed memory in the process, for the next allocations, or returns it to the system.
#pragma once

namespace scanknit {

/// The program frees and allocates the pictures of a frame thirty times a second, and the kernel would clear their
/// pages each time. After this call malloc keeps some freed memory, also of large blocks. Affects the whole process;
/// does nothing if the C library has no such setting.
void keep_freed_memory();

/// Returns to the system what malloc has kept, also between allocations: for the end of a stage whose many small blocks
/// are of no use to the next one. Does nothing without glibc.
void return_freed_memory();

}  // namespace scanknit
