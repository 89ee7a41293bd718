// How the memory that is freed is kept for what comes next.
#pragma once

namespace scanknit {

/// The pictures of a frame are given back and taken again thirty times a second; the kernel would have to clear their
/// pages each time. After this malloc keeps some freed memory, and large pieces are its own. For the whole process;
/// nothing where the C library has no such setting.
void keep_freed_memory();

}  // namespace scanknit
