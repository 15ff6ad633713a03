// SPDX-License-Identifier: Apache-2.0
// Annotations for the thread sanitizer. The sanitizer does not see the synchronization inside TBB,
// because Debian's TBB library is built without it. Therefore the only file that uses TBB is
// compiled without the sanitizer. It calls these functions to declare the order of actions that TBB
// guarantees. All code outside of TBB, including laws, is still checked.
#pragma once

#if defined(VESPER_THREAD_SANITIZER)
#include <sanitizer/tsan_interface.h>
#endif

namespace vesper {

/// Declares that earlier actions of this thread happen before later actions of a thread that calls
/// `ComesAfter(point)`.
inline void ComesBefore([[maybe_unused]] void* point) {
#if defined(VESPER_THREAD_SANITIZER)
  __tsan_release(point);
#endif
}

inline void ComesAfter([[maybe_unused]] void* point) {
#if defined(VESPER_THREAD_SANITIZER)
  __tsan_acquire(point);
#endif
}

}  // namespace vesper
