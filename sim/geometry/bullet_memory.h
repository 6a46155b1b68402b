// Bullet writes to whatever its allocator returns, also to the null pointer of one that is out of memory.
#pragma once

namespace knap {

// From now on Bullet's allocator throws std::bad_alloc instead; before the first use of a tree.
void UseThrowingBulletAllocator();

}  // namespace knap
