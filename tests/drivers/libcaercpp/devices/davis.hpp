// A stub of libcaer's C++ interface: what the recipe of notebooks/board.md calls, in the same
// shape, to compile it without the driver. It has no camera.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#define CAER_HOST_CONFIG_DATAEXCHANGE -3
#define CAER_HOST_CONFIG_DATAEXCHANGE_BLOCKING 1
#define CAER_HOST_CONFIG_PACKETS -4
#define CAER_HOST_CONFIG_PACKETS_MAX_CONTAINER_INTERVAL 1

enum caer_default_event_types { SPECIAL_EVENT = 0, POLARITY_EVENT = 1, FRAME_EVENT = 2 };

namespace libcaer::events {

class EventPacket {
 public:
  virtual ~EventPacket() = default;
  std::int16_t getEventType() const noexcept;
};

class PolarityEventPacket : public EventPacket {
 public:
  struct PolarityEvent {
    std::int64_t getTimestamp64(const PolarityEventPacket& packet) const noexcept;
    bool isValid() const noexcept;
    bool getPolarity() const noexcept;
    std::uint16_t getY() const noexcept;
    std::uint16_t getX() const noexcept;
  };
  const PolarityEvent* begin() const noexcept;
  const PolarityEvent* end() const noexcept;
};

class EventPacketContainer {
 public:
  std::vector<std::shared_ptr<EventPacket>>::iterator begin() noexcept;
  std::vector<std::shared_ptr<EventPacket>>::iterator end() noexcept;
};

}  // namespace libcaer::events

namespace libcaer::devices {

class davis {
 public:
  explicit davis(std::uint16_t device_id);
  void sendDefaultConfig() const;
  void configSet(std::int8_t module, std::uint8_t parameter, std::uint32_t value) const;
  void dataStart(void (*increased)(void*), void (*decreased)(void*), void* user_of_those,
                 void (*shut_down)(void*), void* user_of_that) const;
  void dataStop() const;
  std::unique_ptr<libcaer::events::EventPacketContainer> dataGet() const;
};

}  // namespace libcaer::devices
