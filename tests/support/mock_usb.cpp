#include "support/mock_usb.h"

#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <stdexcept>

namespace planar::test {
namespace {

constexpr std::uint8_t kGetDescriptor = 6;
constexpr std::uint8_t kClearFeature = 1;
constexpr std::uint8_t kSetFeature = 3;
constexpr std::uint8_t kStandardDeviceIn = 0x80;
constexpr std::uint8_t kStandardEndpointOut = 0x02;
constexpr std::size_t kSetupBytes = 8;
/// A mock node always polls as ready, so libusb would spin while it waits.
constexpr unsigned kIdleAnswerDelay_ms = 1;

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <typename T>
using GObjectPtr = std::unique_ptr<T, Unref>;

void throw_if(GError* error) {
  if (error == nullptr) return;
  const std::string message = error->message;
  g_error_free(error);
  throw std::runtime_error("umockdev: " + message);
}

std::string hex(const std::vector<std::uint8_t>& bytes) {
  return fmt::format("{:02X}", fmt::join(bytes, ""));
}

UsbSetup read_setup(const std::uint8_t* bytes) {
  const auto word = [bytes](int at) {
    return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
  };
  return {bytes[0], bytes[1], word(2), word(4), word(6)};
}

UsbOutcome copy_out(const std::vector<std::uint8_t>& bytes, const UsbSetup& setup,
                    std::uint8_t* data) {
  const std::size_t size = std::min<std::size_t>(bytes.size(), setup.length);
  std::copy_n(bytes.begin(), size, data);
  return {0, size};
}

std::vector<std::uint8_t> string_descriptor(const std::string& text) {
  std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(2 + 2 * text.size()), 3};
  for (const char letter : text) {
    bytes.push_back(static_cast<std::uint8_t>(letter));
    bytes.push_back(0);
  }
  return bytes;
}

/// A transfer that the host has submitted and not reaped yet.
struct PendingUrb {
  GObjectPtr<UMockdevIoctlData> urb;
  GObjectPtr<UMockdevIoctlData> buffer;
  int in_endpoint{0};  ///< endpoint of a bulk transfer still to be answered
  std::size_t size{0};
  bool silent{false};
  gint64 ready_us{0};
  UsbOutcome outcome;

  void finish(const UsbOutcome& how) {
    outcome = how;
    in_endpoint = 0;
    silent = false;
    ready_us = 0;
  }
};

/// One opening of the device. What was submitted through it is reaped through it.
struct OpenFile {
  std::deque<PendingUrb> urbs;
  bool idle_since_last_reap{false};
};

GObjectPtr<UMockdevIoctlData> resolve(UMockdevIoctlData* data, std::size_t offset,
                                      std::size_t size) {
  return GObjectPtr<UMockdevIoctlData>(
      umockdev_ioctl_data_resolve(data, offset, static_cast<gsize>(size), nullptr));
}

void complete(UMockdevIoctlClient* client, long result, int error = 0) {
  umockdev_ioctl_client_complete(client, result, error);
}

void complete_late(UMockdevIoctlClient* client, int error) {
  struct Late {
    GObjectPtr<UMockdevIoctlClient> client;
    int error;
  };
  GSource* timer = g_timeout_source_new(kIdleAnswerDelay_ms);
  g_source_set_callback(
      timer,
      [](gpointer data) -> gboolean {
        const auto* late = static_cast<Late*>(data);
        complete(late->client.get(), -1, late->error);
        return G_SOURCE_REMOVE;
      },
      new Late{
          GObjectPtr<UMockdevIoctlClient>(static_cast<UMockdevIoctlClient*>(g_object_ref(client))),
          error},
      [](gpointer data) { delete static_cast<Late*>(data); });
  g_source_attach(timer, g_main_context_get_thread_default());
  g_source_unref(timer);
}

}  // namespace

struct MockUsbBus::Impl {
  GObjectPtr<UMockdevTestbed> testbed{umockdev_testbed_new()};
  int last_address{1};  ///< address 1 is the hub's
};

MockUsbBus::MockUsbBus() : impl_(std::make_unique<Impl>()) {}
MockUsbBus::~MockUsbBus() = default;

bool MockUsbBus::seen_by_this_process() const {
  return umockdev_in_mock_environment() != 0;
}

struct MockUsbDevice::Impl {
  Impl(MockUsbBus::Impl& its_bus, UsbDescription its_description, UsbFunction& its_function)
      : bus(its_bus), description(std::move(its_description)), function(its_function) {
    g_signal_connect(handler.get(), "handle-ioctl", G_CALLBACK(&Impl::on_ioctl), this);
    g_signal_connect(handler.get(), "client-vanished", G_CALLBACK(&Impl::on_close), this);
  }

  static gboolean on_ioctl(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client,
                           gpointer self) {
    static_cast<Impl*>(self)->handle(client);
    return TRUE;
  }
  static void on_close(UMockdevIoctlBase* /*base*/, UMockdevIoctlClient* client, gpointer self) {
    auto* impl = static_cast<Impl*>(self);
    const std::lock_guard lock(impl->mutex);
    impl->open_files.erase(client);
    if (impl->holder == client) impl->holder = nullptr;
  }

  void plug();
  void unplug();
  void add_to_testbed(const std::string& text);
  void handle(UMockdevIoctlClient* client);
  void claim(UMockdevIoctlClient* client);
  void submit(UMockdevIoctlClient* client);
  void reap(UMockdevIoctlClient* client);
  void discard(UMockdevIoctlClient* client);
  void control_at_once(UMockdevIoctlClient* client);
  bool is_ready(PendingUrb& pending, unsigned& waiting_endpoints);
  void control(const std::uint8_t* setup_bytes, std::uint8_t* data, PendingUrb& pending);
  UsbOutcome answer(const UsbSetup& setup, std::uint8_t* data);
  std::optional<UsbFault> take_fault(std::uint8_t request);

  MockUsbBus::Impl& bus;
  const UsbDescription description;
  UsbFunction& function;
  GObjectPtr<UMockdevIoctlBase> handler{umockdev_ioctl_base_new()};
  std::mutex mutex;
  bool plugged{false};
  std::string node, sys_path;
  std::map<UMockdevIoctlClient*, OpenFile> open_files;
  UMockdevIoctlClient* holder{nullptr};  ///< the one that has claimed the interfaces
  std::optional<UsbFault> fault;
};

void MockUsbDevice::Impl::add_to_testbed(const std::string& text) {
  GError* error = nullptr;
  umockdev_testbed_add_from_string(bus.testbed.get(), text.c_str(), &error);
  throw_if(error);
}

void MockUsbDevice::Impl::plug() {
  {
    const std::lock_guard lock(mutex);
    if (plugged) return;
    plugged = true;
  }
  const int address = ++bus.last_address;
  const std::string name = fmt::format("1-{}", address - 1);
  const std::string path = "/devices/pci0000:00/0000:00:14.0/usb1/" + name;
  const auto& d = description.device_descriptor;
  std::vector<std::uint8_t> all = d;
  all.insert(all.end(), description.configuration_descriptor.begin(),
             description.configuration_descriptor.end());
  const auto text_of = [&](std::uint8_t number) {
    return number == 0 ? std::string() : description.strings.at(number - 1U);
  };
  node = fmt::format("/dev/bus/usb/001/{:03}", address);
  sys_path = "/sys" + path;
  // This comes before the device shows, as a client may open it as soon as it does.
  GError* error = nullptr;
  umockdev_testbed_attach_ioctl(bus.testbed.get(), node.c_str(), handler.get(), &error);
  throw_if(error);
  add_to_testbed(fmt::format(
      "P: {path}\nN: bus/usb/001/{address:03}={hex}\nE: DEVNAME={node}\nE: DEVTYPE=usb_device\n"
      "E: SUBSYSTEM=usb\nE: BUSNUM=001\nE: DEVNUM={address:03}\nE: MAJOR=189\nE: MINOR={minor}\n"
      "E: PRODUCT={vendor:x}/{product:x}/{version:x}\nA: busnum=1\\n\nA: devnum={address}\\n\n"
      "A: speed={speed}\\n\nA: bConfigurationValue=1\\n\nA: bNumConfigurations=1\\n\n"
      "A: idVendor={vendor:04x}\\n\nA: idProduct={product:04x}\\n\nA: bcdDevice={version:04x}\\n\n"
      "A: manufacturer={maker}\\n\nA: product={name}\\n\nA: serial={serial}\\n\n"
      "H: descriptors={hex}\n\n",
      fmt::arg("path", path), fmt::arg("address", address), fmt::arg("node", node),
      fmt::arg("minor", address - 1), fmt::arg("vendor", d[9] << 8 | d[8]),
      fmt::arg("product", d[11] << 8 | d[10]), fmt::arg("version", d[13] << 8 | d[12]),
      fmt::arg("speed", description.speed_mbit), fmt::arg("maker", text_of(d[14])),
      fmt::arg("name", text_of(d[15])), fmt::arg("serial", text_of(d[16])),
      fmt::arg("hex", hex(all))));
  // Clients that go by udev alone look for the interface.
  add_to_testbed(fmt::format(
      "P: {0}/{1}:1.0\nE: DEVTYPE=usb_interface\nE: SUBSYSTEM=usb\nE: INTERFACE=255/0/0\n"
      "A: bInterfaceNumber=00\\n\nA: bInterfaceClass=ff\\n\n\n",
      path, name));
}

void MockUsbDevice::Impl::unplug() {
  {
    const std::lock_guard lock(mutex);
    if (!plugged) return;
    plugged = false;
    for (auto& [client, file] : open_files)
      for (PendingUrb& pending : file.urbs) pending.finish({-ESHUTDOWN, 0});
  }
  umockdev_testbed_uevent(bus.testbed.get(), sys_path.c_str(), "remove");
  umockdev_testbed_remove_device(bus.testbed.get(), sys_path.c_str());
}

void MockUsbDevice::Impl::handle(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex);
  switch (umockdev_ioctl_client_get_request(client)) {
    case USBDEVFS_GET_CAPABILITIES: {
      const auto capabilities =
          resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(std::uint32_t));
      const std::uint32_t bits = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                 USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      std::memcpy(capabilities->data, &bits, sizeof bits);
      return complete(client, 0);
    }
    case USBDEVFS_SUBMITURB:
      return submit(client);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return reap(client);
    case USBDEVFS_DISCARDURB:
      return discard(client);
    case USBDEVFS_CONTROL:
      return control_at_once(client);
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
      return claim(client);
    case USBDEVFS_RELEASEINTERFACE:
      if (holder == client) holder = nullptr;
      return complete(client, 0);
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_RESET:
      return plugged ? complete(client, 0) : complete(client, -1, ENODEV);
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
      return complete(client, -1, ENODATA);
    default:
      return complete(client, -1, ENOTTY);
  }
}

void MockUsbDevice::Impl::submit(UMockdevIoctlClient* client) {
  if (!plugged) return complete(client, -1, ENODEV);
  PendingUrb pending;
  pending.urb = resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(usbdevfs_urb));
  const auto* urb = reinterpret_cast<const usbdevfs_urb*>(pending.urb->data);
  pending.size = static_cast<std::size_t>(urb->buffer_length);
  const bool is_control = urb->type == USBDEVFS_URB_TYPE_CONTROL && pending.size >= kSetupBytes;
  if (!is_control && urb->type != USBDEVFS_URB_TYPE_BULK) return complete(client, -1, ENOENT);
  pending.buffer = resolve(pending.urb.get(), offsetof(usbdevfs_urb, buffer), pending.size);
  std::uint8_t* data = pending.buffer ? pending.buffer->data : nullptr;
  if (is_control)
    control(data, data + kSetupBytes, pending);
  else if ((urb->endpoint & 0x80) != 0)
    pending.in_endpoint = urb->endpoint;
  else
    pending.outcome = function.bulk_out(urb->endpoint, data, pending.size);
  open_files[client].urbs.push_back(std::move(pending));
  complete(client, 0);
}

/// Returns true when a transfer can be reaped. A bulk transfer to the host is answered here, once
/// its function has something to send.
bool MockUsbDevice::Impl::is_ready(PendingUrb& pending, unsigned& waiting_endpoints) {
  if (pending.silent || pending.ready_us > g_get_monotonic_time()) return false;
  if (pending.in_endpoint == 0) return true;
  const unsigned endpoint = 1U << (pending.in_endpoint & 0x0f);
  if ((waiting_endpoints & endpoint) != 0) return false;  // an earlier transfer comes first
  const auto outcome = function.bulk_in(
      pending.in_endpoint, pending.buffer ? pending.buffer->data : nullptr, pending.size);
  if (!outcome) {
    waiting_endpoints |= endpoint;
    return false;
  }
  pending.finish(*outcome);
  return true;
}

void MockUsbDevice::Impl::reap(UMockdevIoctlClient* client) {
  unsigned waiting_endpoints = 0;
  OpenFile& file = open_files[client];
  const auto found = std::find_if(file.urbs.begin(), file.urbs.end(), [&](PendingUrb& pending) {
    return is_ready(pending, waiting_endpoints);
  });
  if (found == file.urbs.end()) {
    if (!plugged) return complete(client, -1, ENODEV);
    if (file.idle_since_last_reap) return complete_late(client, EAGAIN);
    file.idle_since_last_reap = true;
    return complete(client, -1, EAGAIN);
  }
  file.idle_since_last_reap = false;
  const PendingUrb done = std::move(*found);
  file.urbs.erase(found);
  auto* urb = reinterpret_cast<usbdevfs_urb*>(done.urb->data);
  urb->status = done.outcome.status;
  urb->actual_length = static_cast<int>(done.outcome.bytes);
  const auto slot = resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(void*));
  umockdev_ioctl_data_set_ptr(slot.get(), 0, done.urb.get());
  complete(client, 0);
}

void MockUsbDevice::Impl::claim(UMockdevIoctlClient* client) {
  if (!plugged) return complete(client, -1, ENODEV);
  if (holder != nullptr && holder != client) return complete(client, -1, EBUSY);
  holder = client;
  complete(client, 0);
}

void MockUsbDevice::Impl::discard(UMockdevIoctlClient* client) {
  gulong address = 0;
  std::memcpy(&address, umockdev_ioctl_client_get_arg(client)->data, sizeof address);
  std::deque<PendingUrb>& urbs = open_files[client].urbs;
  const auto found = std::find_if(urbs.begin(), urbs.end(), [&](const PendingUrb& pending) {
    return pending.urb->client_addr == address;
  });
  if (found == urbs.end()) return complete(client, -1, EINVAL);
  found->finish({-ENOENT, 0});
  complete(client, 0);
}

/// Serves the synchronous path of usbfs, which some clients prefer.
void MockUsbDevice::Impl::control_at_once(UMockdevIoctlClient* client) {
  if (!plugged) return complete(client, -1, ENODEV);
  const auto argument =
      resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(usbdevfs_ctrltransfer));
  const auto* transfer = reinterpret_cast<const usbdevfs_ctrltransfer*>(argument->data);
  std::uint8_t setup[kSetupBytes];
  std::memcpy(setup, transfer, sizeof setup);  // usbfs orders these fields as the wire does
  PendingUrb pending;
  if (transfer->wLength > 0)
    pending.buffer =
        resolve(argument.get(), offsetof(usbdevfs_ctrltransfer, data), transfer->wLength);
  control(setup, pending.buffer ? pending.buffer->data : nullptr, pending);
  if (pending.silent) return complete(client, -1, ETIMEDOUT);
  if (pending.outcome.status != 0) return complete(client, -1, -pending.outcome.status);
  complete(client, static_cast<long>(pending.outcome.bytes));
}

std::optional<UsbFault> MockUsbDevice::Impl::take_fault(std::uint8_t request) {
  if (!fault || (fault->request && *fault->request != request)) return std::nullopt;
  const UsbFault taken = *fault;
  if (fault->count > 0 && --fault->count == 0) fault.reset();
  return taken;
}

void MockUsbDevice::Impl::control(const std::uint8_t* setup_bytes, std::uint8_t* data,
                                  PendingUrb& pending) {
  const UsbSetup setup = read_setup(setup_bytes);
  const std::optional<UsbFault> wrong = take_fault(setup.request);
  if (wrong && wrong->kind == UsbFault::Kind::kStall)
    pending.outcome = {-EPIPE, 0};
  else if (wrong && wrong->kind == UsbFault::Kind::kIoError)
    pending.outcome = {-EPROTO, 0};
  else if (wrong && wrong->kind == UsbFault::Kind::kSilence)
    pending.silent = true;
  else
    pending.outcome = answer(setup, data);
  if (wrong && wrong->kind == UsbFault::Kind::kShort)
    pending.outcome.bytes = std::min(pending.outcome.bytes, wrong->bytes);
  if (wrong && wrong->kind == UsbFault::Kind::kLate)
    pending.ready_us = g_get_monotonic_time() + static_cast<gint64>(wrong->late_s * 1e6);
}

UsbOutcome MockUsbDevice::Impl::answer(const UsbSetup& setup, std::uint8_t* data) {
  if (setup.request_type == kStandardDeviceIn && setup.request == kGetDescriptor) {
    const unsigned number = setup.value & 0xffU;
    switch (setup.value >> 8) {
      case 1:
        return copy_out(description.device_descriptor, setup, data);
      case 2:
        return copy_out(description.configuration_descriptor, setup, data);
      case 3:
        if (number == 0) return copy_out({4, 3, 0x09, 0x04}, setup, data);
        if (number <= description.strings.size())
          return copy_out(string_descriptor(description.strings[number - 1]), setup, data);
        return {-EPIPE, 0};
      default:
        return {-EPIPE, 0};
    }
  }
  if (setup.request_type == kStandardEndpointOut &&
      (setup.request == kClearFeature || setup.request == kSetFeature))
    return {0, 0};
  return function.control(setup, data);
}

MockUsbDevice::MockUsbDevice(MockUsbBus& bus, UsbDescription description, UsbFunction& function)
    : impl_(std::make_unique<Impl>(*bus.impl_, std::move(description), function)) {
  plug();
}

MockUsbDevice::~MockUsbDevice() {
  unplug();
}

void MockUsbDevice::plug() {
  impl_->plug();
}

void MockUsbDevice::unplug() {
  impl_->unplug();
}

void MockUsbDevice::inject(const UsbFault& fault) {
  const std::lock_guard lock(impl_->mutex);
  impl_->fault = fault;
}

void MockUsbDevice::clear_fault() {
  const std::lock_guard lock(impl_->mutex);
  impl_->fault.reset();
}

}  // namespace planar::test
