// Numbers by which two machines find out whether Bullet computes alike on them: the known scenario of knap's own
// numbers (known_numbers.h) in Bullet, all states of it, and Bullet's version. It takes some milliseconds.
#pragma once

#include <vector>

namespace knap {

// Pure; the same bits in every call of one process.
std::vector<double> CalcTransferNumbers();

}  // namespace knap
