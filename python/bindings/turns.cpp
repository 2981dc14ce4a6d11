#include "turns.hpp"

#include <algorithm>
#include <unordered_set>
#include <utility>
#include <vector>

#include "gil.hpp"

namespace asap::python {
namespace {

struct KnownTurns {
  PyObject* object;
  std::weak_ptr<Turns> turns;
  std::uint64_t forks;  // a thread of the parent process does not give its turn back here
};

// Of the objects that are worked with.
std::vector<KnownTurns>& known_turns() {
  static auto& all = *new std::vector<KnownTurns>;  // outlives every thread
  std::erase_if(all,
                [](const KnownTurns& one) { return one.turns.expired() || one.forks != forks(); });
  return all;
}

// Objects that have been worked with, for as long as they live.
std::unordered_set<PyObject*>& worked() {
  static auto& all = *new std::unordered_set<PyObject*>;
  return all;
}

void note_work(py::handle object) {
  if (!PyType_SUPPORTS_WEAKREFS(Py_TYPE(object.ptr()))) return;  // none of ours: refused later
  if (!worked().insert(object.ptr()).second) return;
  py::weakref(object, py::cpp_function([gone = object.ptr()](py::handle reference) {
                worked().erase(gone);
                reference.dec_ref();
              }))
      .release();
}

}  // namespace

bool Turns::try_lock() noexcept {
  std::uint32_t own = serving_.load(std::memory_order_acquire);
  if (!next_.compare_exchange_strong(own, own + 1, std::memory_order_acquire)) return false;
  owner_ = std::this_thread::get_id();
  return true;
}

void Turns::lock() noexcept {
  const std::uint32_t own = next_.fetch_add(1, std::memory_order_relaxed);
  for (;;) {
    const std::uint32_t now = serving_.load(std::memory_order_acquire);
    if (now == own) break;
    serving_.wait(now, std::memory_order_acquire);
  }
  owner_ = std::this_thread::get_id();
}

void Turns::unlock() noexcept {
  owner_ = std::thread::id();
  serving_.fetch_add(1, std::memory_order_release);
  serving_.notify_all();
}

std::shared_ptr<Turns> turns_under_way_at(py::handle object) {
  const auto& all = known_turns();
  const auto found = std::ranges::find(all, object.ptr(), &KnownTurns::object);
  return found == all.end() ? nullptr : found->turns.lock();
}

std::shared_ptr<Turns> turns_at(py::handle object) {
  note_work(object);
  if (auto turns = turns_under_way_at(object)) return turns;
  auto turns = std::make_shared<Turns>();
  known_turns().push_back({object.ptr(), turns, forks()});
  return turns;
}

bool has_worked(py::handle object) { return worked().contains(object.ptr()); }

CallersTurn::CallersTurn(std::shared_ptr<Turns> turns) {
  if (turns == nullptr || turns->are_mine()) return;
  if (!turns->try_lock()) {
    if (is_exiting()) return;  // who has it may never come back
    const WithoutGil release;  // who has it may need it to come to its end
    turns->lock();
  }
  turns_ = std::move(turns);
}

CallersTurn::~CallersTurn() {
  if (turns_ != nullptr) turns_->unlock();
}

}  // namespace asap::python
