// touch_code(), touch_stack(): bring the program's code and the calling thread's stack into memory
// before the first event. Without them the hot path waits some microseconds at the first use of
// each page. The objects that own the rest of the memory do the same for it (RunConfig::prefault).
// Any thread; no allocation.
#pragma once

namespace asap::inline v0_1 {

// Reads all pages of the program, or of the shared object, that this library is linked into. The
// code of others, such as the C++ library, is the business of mlockall(). Linux; else nothing.
void touch_code() noexcept;

// Writes to the next 64 KiB of the stack. The library's part of the loop takes less than 4 KiB.
void touch_stack() noexcept;

}  // namespace asap::inline v0_1
