// What must hold at any moment in the book that a RequestTable keeps.
#pragma once

#include <string>

#include "coordinator/dispatch/request_table.h"

namespace knap {

// The first way in which the book does not agree with itself, naming the request or the worker; empty when it agrees.
//
// A waiting request is in the queue, once, and nobody holds it; a leased one is not, and one or two workers hold it,
// who have it in their holdings; an answered one is in neither, nobody wants it any more, and its acknowledgement is
// owed. Nothing is in the queue, in a holding or among what is sent next that is not a request of that state. A worker
// that is kept apart holds one suspect alone. Nobody holds more than a worker takes.
std::string FindDefect(const RequestBook& book);

}  // namespace knap
