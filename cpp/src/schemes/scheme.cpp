#include "asap/schemes/scheme.hpp"

#include <memory>

#include "asap/schemes/asap2020.hpp"
#include "asap/schemes/asap2022.hpp"
#include "asap/schemes/dead_beat.hpp"
#include "asap/schemes/deadline.hpp"
#include "asap/schemes/fixed.hpp"
#include "asap/schemes/greedy.hpp"
#include "core/made.hpp"

namespace asap::inline v0_1 {

Decision LearningScheme::decide(const Backlog& backlog) noexcept { return law_->decide(backlog); }
void LearningScheme::observe(const Outcome& outcome) noexcept { law_->observe(outcome); }
void LearningScheme::reset(Execution execution) noexcept { law_->reset(execution); }
std::string_view LearningScheme::name() const noexcept { return law_->name(); }
SchemeParameters LearningScheme::parameters() const { return law_->parameters(); }
std::int64_t LearningScheme::latency_bound_ns() const noexcept { return law_->latency_bound_ns(); }
void LearningScheme::set_latency_bound_ns(std::int64_t bound_ns) noexcept {
  law_->set_latency_bound_ns(bound_ns);
}

template <class Made>
Result<Made> make_scheme(const typename Made::Config& config) noexcept {
  return made<Made>([&] { return std::make_unique<Made>(config); });
}

template Result<Asap2020> make_scheme<Asap2020>(const Asap2020::Config&) noexcept;
template Result<Asap2022> make_scheme<Asap2022>(const Asap2022::Config&) noexcept;
template Result<DeadBeat> make_scheme<DeadBeat>(const DeadBeat::Config&) noexcept;
template Result<Deadline> make_scheme<Deadline>(const Deadline::Config&) noexcept;
template Result<FixedSize> make_scheme<FixedSize>(const FixedSize::Config&) noexcept;
template Result<FixedTime> make_scheme<FixedTime>(const FixedTime::Config&) noexcept;
template Result<Greedy> make_scheme<Greedy>(const Greedy::Config&) noexcept;
template Result<SingleEvent> make_scheme<SingleEvent>(const SingleEvent::Config&) noexcept;

}  // namespace asap::inline v0_1
