#include "support/usb3_camera.h"

#include <arv.h>
#include <endian.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace planar::test {
namespace {

// The addresses of the tables of registers. The features' own registers are at kFeatures plus the
// address in the XML, out of the way of the standard's.
constexpr std::uint64_t kSbrm = 0x10000;      // technology-specific bootstrap registers
constexpr std::uint64_t kSirm = 0x20000;      // registers of the streaming interface
constexpr std::uint64_t kManifest = 0x30000;  // manifest of the XML file
constexpr std::uint64_t kXml = 0x1000000;
constexpr std::uint64_t kFeatures = 0x500000;
// The pixel format is kept here: the fake camera takes pictures of 8 bits, whatever is sent of
// them.
constexpr std::uint64_t kPixelFormat = kFeatures + ARV_FAKE_CAMERA_REGISTER_PIXEL_FORMAT;
constexpr std::size_t kAbrmBytes = 0x300, kSbrmBytes = 0x80, kSirmBytes = 0x40;
constexpr std::size_t kManifestBytes = 0x100;
constexpr std::size_t kStreamControl = 0x04;  // in the SIRM; bit 0 enables

constexpr std::uint32_t kCommandMagic = 0x43563355;  // "U3VC"
constexpr std::uint32_t kLeaderMagic = 0x4c563355;   // "U3VL"
constexpr std::uint32_t kTrailerMagic = 0x54563355;  // "U3VT"
constexpr std::uint16_t kReadMemory = 0x0800, kWriteMemory = 0x0802;
constexpr std::uint16_t kInvalidAddress = 0x8003, kNotImplemented = 0x8001;
constexpr std::size_t kCommandHeaderBytes = 12, kAddressBytes = 8;
constexpr std::size_t kLeaderBytes = 52, kTrailerBytes = 28;
constexpr std::uint16_t kImagePayload = 1;

constexpr int kAnswerEndpoint = 0x81;
constexpr int kStreamEndpoint = 0x82;

/// Registers that Aravis' fake camera does not have.
constexpr guint32 kGamma = 0x800, kReverseX = 0x804;
constexpr guint32 kLineSource = 0x80c, kTimerDelay = 0x814, kTimerDuration = 0x818;

/// A feature of numbers, or of named values that count from 0, with a register of its own.
std::string feature_xml(const std::string& name, const std::string& address,
                        const std::vector<std::string>& words) {
  std::string entries;
  for (std::size_t i = 0; i < words.size(); ++i)
    entries += "<EnumEntry Name=\"" + words[i] + "\" NameSpace=\"Standard\"><Value>" +
               std::to_string(i) + "</Value></EnumEntry>";
  const std::string kind = words.empty() ? "Float" : "Enumeration";
  const std::string reg = words.empty() ? "FloatReg" : "IntReg";
  return "<" + kind + " Name=\"" + name + "\" NameSpace=\"Standard\">" + entries + "<pValue>" +
         name + "Register</pValue></" + kind + "><" + reg + " Name=\"" + name +
         "Register\" NameSpace=\"Custom\"><Address>0x500" + address +
         "</Address><Length>4</Length><AccessMode>RW</AccessMode><pPort>Device</pPort>" +
         (words.empty() ? "" : "<Sign>Unsigned</Sign>") + "<Endianess>BigEndian</Endianess></" +
         reg + ">";
}

template <typename T>
T get(const std::uint8_t* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

template <typename T>
void put(std::vector<std::uint8_t>& bytes, std::size_t at, T value) {
  if (bytes.size() < at + sizeof value) bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

void put_text(std::vector<std::uint8_t>& bytes, std::size_t at, const std::string& text) {
  std::copy(text.begin(), text.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
}

/// Returns the fake camera's XML with its registers moved to kFeatures, and with more pixel
/// formats.
std::string moved_xml(ArvFakeCamera* camera) {
  std::size_t size = 0;
  const char* text = arv_fake_camera_get_genicam_xml(camera, &size);
  std::string xml(text, size);
  const std::string tag = "<Address>0x";
  for (std::size_t at = xml.find(tag); at != std::string::npos; at = xml.find(tag, at + 1)) {
    const std::size_t digits = at + tag.size();
    const std::size_t end = xml.find('<', digits);
    xml.replace(at + tag.size(), end - digits,
                "500" + std::string(3 - (end - digits), '0') + xml.substr(digits, end - digits));
  }
  std::string entries;
  for (const GreyFormat& format : grey_formats())
    if (format.bits > 8)
      entries += "<EnumEntry Name=\"" + format.name + "\" NameSpace=\"Standard\"><Value>" +
                 std::to_string(format.code) + "</Value></EnumEntry>";
  xml.insert(xml.find("<pValue>PixelFormatRegister</pValue>"), entries);
  const std::string processing = R"(
    <Float Name="Gamma" NameSpace="Standard"><pValue>GammaRegister</pValue></Float>
    <FloatReg Name="GammaRegister" NameSpace="Custom"><Address>0x500800</Address><Length>4</Length>
      <AccessMode>RW</AccessMode><pPort>Device</pPort>
      <Endianess>BigEndian</Endianess></FloatReg>
    <Boolean Name="ReverseX" NameSpace="Standard"><pValue>ReverseXRegister</pValue></Boolean>
    <IntReg Name="ReverseXRegister" NameSpace="Custom"><Address>0x500804</Address><Length>4</Length>
      <AccessMode>RW</AccessMode><pPort>Device</pPort><Sign>Unsigned</Sign>
      <Endianess>BigEndian</Endianess></IntReg>
)";
  const std::string strobe = feature_xml("LineSelector", "820", {"Line0", "Line1"}) +
                             feature_xml("LineMode", "808", {"Input", "Output"}) +
                             feature_xml("LineSource", "80c", {"Off", "ExposureActive", "Timer0"}) +
                             feature_xml("TimerSelector", "81c", {"Timer0"}) +
                             feature_xml("TimerTriggerSource", "810", {"Off", "ExposureStart"}) +
                             feature_xml("TimerDelay", "814", {}) +
                             feature_xml("TimerDuration", "818", {});
  xml.insert(xml.find("<Integer Name=\"BinningHorizontal\""), processing + strobe);
  return xml;
}

UsbOutcome send(const std::vector<std::uint8_t>& bytes, std::uint8_t* data, std::size_t size) {
  if (size < bytes.size()) return {-EOVERFLOW, size};
  std::copy(bytes.begin(), bytes.end(), data);
  return {0, bytes.size()};
}

}  // namespace

struct Usb3Camera::Handles {
  explicit Handles(const std::string& serial) : camera(arv_fake_camera_new(serial.c_str())) {}
  ~Handles() {
    if (buffer != nullptr) g_object_unref(buffer);
    g_object_unref(camera);
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;

  ArvFakeCamera* camera;
  ArvBuffer* buffer{nullptr};
};

Usb3Camera::Usb3Camera(const std::string& serial, const cv::Size& sensor_px, double frame_rate_hz,
                       Exposure exposure, bool keeps_gamma)
    : handles_(std::make_unique<Handles>(serial)),
      serial_(serial),
      exposure_([this, exposure = std::move(exposure)](const cv::Rect& region_px, double light) {
        const cv::Mat picture = exposure(region_px, light);
        return lit_by_line_ && line_source() == 0 ? cv::Mat(picture / 4.0) : picture;
      }),
      keeps_gamma_(keeps_gamma),
      xml_(moved_xml(handles_->camera)),
      stream_registers_(kSirmBytes),
      format_(&grey_formats().front()),
      switched_on_us_(g_get_monotonic_time()) {
  show_on(handles_->camera, exposure_, sensor_px, frame_rate_hz);
  set_processing(1.0F, false);
}

void Usb3Camera::set_processing(float gamma, bool reversed) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &gamma, sizeof bits);
  arv_fake_camera_write_register(handles_->camera, kGamma, bits);
  arv_fake_camera_write_register(handles_->camera, kReverseX, reversed ? 1 : 0);
}

std::uint32_t Usb3Camera::line_source() const {
  guint32 value = 0;
  arv_fake_camera_read_register(handles_->camera, kLineSource, &value);
  return value;
}

std::pair<float, float> Usb3Camera::timer_us() const {
  float values[2]{};
  for (const guint32 i : {0U, 1U}) {
    guint32 bits = 0;
    arv_fake_camera_read_register(handles_->camera, i == 0 ? kTimerDelay : kTimerDuration, &bits);
    std::memcpy(&values[i], &bits, sizeof bits);
  }
  return {values[0], values[1]};
}

Usb3Camera::~Usb3Camera() = default;

UsbDescription Usb3Camera::description() const {
  UsbDescription description;
  description.device_descriptor = {18,   1,    0x10, 0x03, 0xef, 2, 1, 9, 0xa2,
                                   0x2b, 0x55, 0x4d, 0,    1,    1, 2, 3, 1};
  Bytes& all = description.configuration_descriptor;
  all = {9,  2,    0,    0, 2, 1,    0, 0x80, 112,  // two interfaces
         9,  4,    0,    0, 2, 0xef, 5, 0,    0,    // commands
         20, 0x24, 1,    0, 0, 1,    0, 0,    0,   1,    0, 4, 1, 2,
         0,  0,    0,    3, 0, 8,                                     // GenCP, strings 4, 1, 2
         7,  5,    0x81, 2, 0, 4,    0, 7,    5,   0x01, 2, 0, 4, 0,  // bulk in and out
         9,  4,    1,    0, 1, 0xef, 5, 2,    0,                      // stream
         7,  5,    0x82, 2, 0, 4,    0};
  put<std::uint16_t>(all, 2, static_cast<std::uint16_t>(all.size()));
  description.strings = {"Daheng Imaging", "Emulated", serial_, "2BA2" + serial_};
  description.speed_mbit = 5000;
  return description;
}

UsbOutcome Usb3Camera::control(const UsbSetup& /*setup*/, std::uint8_t* /*data*/) {
  return {-EPIPE, 0};
}

void Usb3Camera::power_cycle() {
  arv_fake_camera_write_register(handles_->camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION, 0);
  std::fill(stream_registers_.begin(), stream_registers_.end(), std::uint8_t{0});
  answers_.clear();
  next_ = Next::kLeader;
  format_ = &grey_formats().front();
  switched_on_us_ = g_get_monotonic_time();
}

std::optional<Usb3Camera::Bytes> Usb3Camera::read(std::uint64_t address, std::size_t size) {
  Bytes bytes(size);
  if (address >= kXml) {
    const std::uint64_t from = address - kXml;
    if (from < xml_.size())
      std::memcpy(bytes.data(), xml_.data() + from,
                  std::min<std::size_t>(size, xml_.size() - from));
    return bytes;
  }
  if (address == kPixelFormat) {
    put(bytes, 0, htobe32(format_->code));
    return bytes;
  }
  if (address >= kFeatures) {
    if (!arv_fake_camera_read_memory(handles_->camera, static_cast<guint32>(address - kFeatures),
                                     static_cast<guint32>(size), bytes.data()))
      return std::nullopt;
    return bytes;
  }
  Bytes table;
  std::uint64_t start = 0;
  if (address >= kManifest) {
    start = kManifest;
    table.resize(kManifestBytes);
    put<std::uint64_t>(table, 0x00, 1);  // one entry
    put<std::uint64_t>(table, 0x10, kXml);
    put<std::uint64_t>(table, 0x18, xml_.size());
  } else if (address >= kSirm) {
    start = kSirm;
    table = stream_registers_;
    put<std::uint32_t>(table, 0x00, 0x0a000000);  // sizes in steps of 1024 bytes, as Daheng has
    put<std::uint64_t>(table, 0x08, payload_bytes());
    put<std::uint32_t>(table, 0x10, kLeaderBytes);
    put<std::uint32_t>(table, 0x14, kTrailerBytes);
  } else if (address >= kSbrm) {
    start = kSbrm;
    table.resize(kSbrmBytes);
    put<std::uint32_t>(table, 0x14, 1024);  // longest command and longest answer
    put<std::uint32_t>(table, 0x18, 1024);
    put<std::uint32_t>(table, 0x1c, 1);  // number of stream channels
    put<std::uint64_t>(table, 0x20, kSirm);
    put<std::uint32_t>(table, 0x28, kSirmBytes);
  } else {
    table.resize(kAbrmBytes);
    put_text(table, 0x04, "Daheng Imaging");
    put_text(table, 0x44, "Emulated");
    put_text(table, 0x144, serial_);
    put<std::uint32_t>(table, 0x1cc, 300);  // time that an answer may take, ms
    put<std::uint64_t>(table, 0x1d0, kManifest);
    put<std::uint64_t>(table, 0x1d8, kSbrm);
  }
  const std::uint64_t from = address - start;
  if (from + size > table.size()) return std::nullopt;
  std::memcpy(bytes.data(), table.data() + from, size);
  return bytes;
}

bool Usb3Camera::write(std::uint64_t address, const std::uint8_t* data, std::size_t size) {
  if (keeps_gamma_ && address == kFeatures + kGamma) return true;
  if (address == kPixelFormat) return set_format(be32toh(get<std::uint32_t>(data)));
  if (address >= kFeatures && address < kXml)
    return arv_fake_camera_write_memory(handles_->camera, static_cast<guint32>(address - kFeatures),
                                        static_cast<guint32>(size), data) != 0;
  if (address < kSirm || address + size > kSirm + kSirmBytes) return false;
  std::copy_n(data, size, stream_registers_.begin() + static_cast<std::ptrdiff_t>(address - kSirm));
  if (address == kSirm + kStreamControl) next_ = Next::kLeader;
  return true;
}

UsbOutcome Usb3Camera::bulk_out(int /*endpoint*/, const std::uint8_t* data, std::size_t size) {
  if (size < kCommandHeaderBytes + kAddressBytes || get<std::uint32_t>(data) != kCommandMagic)
    return {-EPIPE, 0};
  const auto command = get<std::uint16_t>(data + 6);
  const auto length = get<std::uint16_t>(data + 8);
  const auto id = get<std::uint16_t>(data + 10);
  const auto address = get<std::uint64_t>(data + kCommandHeaderBytes);
  const std::uint8_t* rest = data + kCommandHeaderBytes + kAddressBytes;
  std::uint16_t status = 0;
  Bytes content;
  if (command == kReadMemory) {
    const auto bytes = read(address, get<std::uint16_t>(rest + 2));
    if (bytes) content = *bytes;
    if (!bytes) status = kInvalidAddress;
  } else if (command == kWriteMemory) {
    const std::size_t written = length - kAddressBytes;
    if (!write(address, rest, written)) status = kInvalidAddress;
    put<std::uint16_t>(content, 2, static_cast<std::uint16_t>(written));
  } else {
    status = kNotImplemented;
  }
  Bytes answer;
  put(answer, 0, kCommandMagic);
  put(answer, 4, status);
  put(answer, 6, static_cast<std::uint16_t>(command + 1));
  put(answer, 8, static_cast<std::uint16_t>(content.size()));
  put(answer, 10, id);
  answer.insert(answer.end(), content.begin(), content.end());
  answers_.push_back(answer);
  return {0, size};
}

std::optional<UsbOutcome> Usb3Camera::bulk_in(int endpoint, std::uint8_t* data, std::size_t size) {
  if (endpoint == kStreamEndpoint) return stream(data, size);
  if (endpoint != kAnswerEndpoint) return UsbOutcome{-EPIPE, 0};
  if (answers_.empty()) return std::nullopt;
  const UsbOutcome outcome = send(answers_.front(), data, size);
  answers_.pop_front();
  return outcome;
}

bool Usb3Camera::set_format(std::uint32_t code) {
  for (const GreyFormat& format : grey_formats()) {
    if (format.code != code) continue;
    format_ = &format;
    return true;
  }
  return false;
}

std::size_t Usb3Camera::payload_bytes() const {
  return format_->bytes(arv_fake_camera_get_payload(handles_->camera));
}

void Usb3Camera::pack() {
  std::size_t ignored = 0;
  const auto* pixels =
      static_cast<const std::uint8_t*>(arv_buffer_get_data(handles_->buffer, &ignored));
  sending_ = pixels;
  sending_bytes_ = pixels_;
  if (format_->bits == 8) return;
  std::vector<unsigned> levels(pixels_);
  const int lower_bits = format_->bits - 8;
  for (std::size_t i = 0; i < pixels_; ++i)
    levels[i] = static_cast<unsigned>(pixels[i]) << lower_bits |
                (static_cast<unsigned>(i) & ((1U << lower_bits) - 1U));
  packed_ = format_->pack(levels);
  sending_ = packed_.data();
  sending_bytes_ = packed_.size();
}

std::uint64_t Usb3Camera::stamp_ns() const {
  const auto on_us = static_cast<double>(g_get_monotonic_time() - switched_on_us_);
  return static_cast<std::uint64_t>(1e3 * clock_rate_ * on_us);
}

bool Usb3Camera::streaming() const {
  return (stream_registers_[kStreamControl] & 1) != 0 &&
         arv_fake_camera_get_acquisition_status(handles_->camera) != 0;
}

std::optional<UsbOutcome> Usb3Camera::stream(std::uint8_t* data, std::size_t size) {
  if (!streaming()) return std::nullopt;
  switch (next_) {
    case Next::kLeader:
      if (!frame_is_due()) return std::nullopt;
      return send_leader(data, size);
    case Next::kPayload:
      return send_payload(data, size);
    case Next::kTrailer:
      return send_trailer(data, size);
  }
  return std::nullopt;
}

bool Usb3Camera::frame_is_due() {
  ArvFakeCamera* const camera = handles_->camera;
  const bool line_pulsed = line_pulses_ > 0;
  if (line_pulsed) --line_pulses_;
  if (arv_fake_camera_is_in_software_trigger_mode(camera))
    return arv_fake_camera_check_and_acknowledge_software_trigger(camera);
  if (!arv_fake_camera_is_in_free_running_mode(camera)) return line_pulsed;
  const std::int64_t now_us = g_get_monotonic_time();
  if (now_us < next_frame_us_) return false;
  guint32 period_us = 0;
  arv_fake_camera_read_register(camera, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US,
                                &period_us);
  next_frame_us_ = std::max(next_frame_us_ + period_us, now_us - period_us);
  return true;
}

UsbOutcome Usb3Camera::send_leader(std::uint8_t* data, std::size_t size) {
  const std::size_t pixels = arv_fake_camera_get_payload(handles_->camera);  // of 8 bits
  if (pixels != pixels_) {
    if (handles_->buffer != nullptr) g_object_unref(handles_->buffer);
    handles_->buffer = arv_buffer_new_allocate(pixels);
    pixels_ = pixels;
  }
  ArvBuffer* const buffer = handles_->buffer;
  const std::uint64_t exposed_ns = stamp_ns();
  arv_fake_camera_fill_buffer(handles_->camera, buffer, nullptr);
  pack();
  ++frame_id_;
  sent_bytes_ = 0;
  next_ = Next::kPayload;
  Bytes leader(kLeaderBytes);
  put(leader, 0, kLeaderMagic);
  put(leader, 6, static_cast<std::uint16_t>(kLeaderBytes));
  put(leader, 8, frame_id_);
  put(leader, 18, kImagePayload);
  put(leader, 20, exposed_ns);
  put(leader, 28, format_->code);
  gint region[4];
  arv_buffer_get_image_region(buffer, &region[0], &region[1], &region[2], &region[3]);
  put(leader, 32, region[2]);
  put(leader, 36, region[3]);
  put(leader, 40, region[0]);
  put(leader, 44, region[1]);
  return send(leader, data, size);
}

UsbOutcome Usb3Camera::send_payload(std::uint8_t* data, std::size_t size) {
  const std::size_t bytes = std::min(size, sending_bytes_ - sent_bytes_);
  std::memcpy(data, sending_ + sent_bytes_, bytes);
  sent_bytes_ += bytes;
  if (sent_bytes_ == sending_bytes_) {
    next_ = Next::kTrailer;
    if (trailers_to_lose_ > 0) {
      --trailers_to_lose_;
      next_ = Next::kLeader;
    }
  }
  if (payloads_to_cut_ == 0) return {0, bytes};
  --payloads_to_cut_;
  return {0, bytes / 2};
}

UsbOutcome Usb3Camera::send_trailer(std::uint8_t* data, std::size_t size) {
  next_ = Next::kLeader;
  Bytes trailer(kTrailerBytes);
  put(trailer, 0, kTrailerMagic);
  put(trailer, 6, static_cast<std::uint16_t>(kTrailerBytes));
  put(trailer, 8, frame_id_);
  put(trailer, 20, static_cast<std::uint64_t>(sending_bytes_));
  return send(trailer, data, size);
}

}  // namespace planar::test
