// touch_code(), touch_stack(): have those pages in memory before the first event that no object
// holds: the program's code and the stack of the calling thread. Else each is missed once, on the
// hot path, for some microseconds. The rest of RunConfig::prefault is with whoever owns the memory.
// Any thread; no allocation.
#pragma once

namespace asap {

// Reads all pages of the program, or of the shared object, that this library is linked into. The
// code of others, such as the C++ library, is the business of mlockall(). Linux; else nothing.
void touch_code() noexcept;

// Writes to the next 64 KiB of the stack. The library's part of the loop takes less than 4 KiB.
void touch_stack() noexcept;

}  // namespace asap
