// The ring under Relacy: the source of the production build, against the C++ memory model.
// Contents, order, the end of the stream, and no event dropped while there is room.
#include "buffer/event_buffer.hpp"

namespace asap::model {
namespace {

using Ring = BasicEventBuffer<RelacyAtomics, 1>;  // goes back to the first slot when it can
using Size = std::size_t;

// The producer tries again with what did not fit, then closes. The consumer looks in pieces of any
// size until it has seen the end. An exhaustive search has no `any` sizes, but the largest.
template <unsigned capacity, unsigned batch, unsigned total, bool any>
struct Stream : rl::test_suite<Stream<capacity, batch, total, any>, 2> {
  Ring ring{capacity, ~std::uint64_t{0} - 1};  // the indices wrap on the way

  void thread(unsigned index) { index == 0 ? produce() : consume(); }

  static unsigned up_to(unsigned most) { return any ? 1 + rl::rand(most) : most; }

  void produce() {
    std::array<Event, batch> events;
    for (unsigned pushed = 0; pushed < total;) {
      const unsigned size = std::min(up_to(batch), total - pushed);
      for (unsigned i = 0; i < size; ++i) events[i] = Event(pushed + i);
      const Size taken = ring.push(EventSpan(events).first(size));
      RL_ASSERT(taken <= size);
      pushed += static_cast<unsigned>(taken);
      if (taken == 0) RelacyWait::pause();
    }
    ring.close();
  }

  void consume() {
    unsigned seen = 0;
    for (;;) {
      const bool done = ring.closed();
      const EventPieces pieces = ring.peek(up_to(capacity));
      for (Size i = 0; i < pieces.size(); ++i) RL_ASSERT(pieces[i].number($) == seen + i);
      seen += static_cast<unsigned>(pieces.size());
      ring.consume(pieces.size());
      if (pieces.size() > 0) continue;
      if (done) break;
      RelacyWait::pause();
    }
    RL_ASSERT(seen == total);
  }
};

// Both sides hear by another way that there is room, or that something is there: then the ring must
// know it too, whatever its copies of the indices say.
template <unsigned capacity>
struct Exact : rl::test_suite<Exact<capacity>, 2> {
  Ring ring{capacity};
  RelacyAtomics::Atomic<unsigned> filled{0};
  RelacyAtomics::Atomic<unsigned> emptied{0};

  static void await(const RelacyAtomics::Atomic<unsigned>& round, unsigned wanted) {
    while (round.load(std::memory_order_acquire) < wanted) RelacyWait::pause();
  }

  void thread(unsigned index) {
    for (unsigned round = 1; round <= 2; ++round) {
      if (index == 0) {
        const std::array<Event, capacity + 1> events = filling();
        RL_ASSERT(ring.push(events) == capacity);
        RL_ASSERT(ring.overflow() == round);
        RL_ASSERT(ring.size() == capacity);
        filled.store(round, std::memory_order_release);
        await(emptied, round);
      } else {
        await(filled, round);
        RL_ASSERT(ring.peek().size() == capacity);
        ring.consume(capacity);
        emptied.store(round, std::memory_order_release);
      }
    }
  }

  static std::array<Event, capacity + 1> filling() {
    std::array<Event, capacity + 1> events;
    for (Event& event : events) event = Event(7);
    return events;
  }
};

template <unsigned capacity, unsigned batch>
void stream(const Depth& depth) {
  const std::string name = "ring of " + std::to_string(capacity) + ", batches to ";
  random<Stream<capacity, batch, 5, true>>(name + std::to_string(batch), depth);
  exhaustive<Stream<capacity, batch, (batch > 2 ? batch : 2), false>>(name + std::to_string(batch),
                                                                      depth);
}

template <unsigned capacity>
void all(const Depth& depth) {
  stream<capacity, 1>(depth);
  stream<capacity, 2>(depth);
  stream<capacity, 3>(depth);
  random<Exact<capacity>>("ring of " + std::to_string(capacity) + ", exact", depth);
}

}  // namespace
}  // namespace asap::model

int main(int count, char** arguments) {
  using namespace asap::model;
  const Depth depth(count, arguments);
#ifdef BRIEF
  random<Stream<2, 2, 5, true>>("ring of 2, batches to 2", depth);
  random<Exact<2>>("ring of 2, exact", depth);
#else
  all<1>(depth);
  all<2>(depth);
  all<3>(depth);
  all<4>(depth);
#endif
}
