#include "planar_servo/hardware/links/modbus_link.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <termios.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <thread>
#include <utility>

#include "planar_servo/base/core/error.h"
#include "planar_servo/hardware/drives/grbl_board.h"

namespace planar {
namespace {

constexpr int kTries = 3;
/// So many errors are told at once, for they may spoil a move; fewer at the end.
constexpr int kWorthAWord = 10;
/// A driver that was started says that it moves by then; one that searches does not rest for longer
/// between two ways.
constexpr std::chrono::milliseconds kBeginning{100};
constexpr long kWord = 0x10000;

long exchanged(long value) {
  const auto bits = static_cast<std::uint32_t>(value);
  return static_cast<std::int32_t>(bits << 16 | bits >> 16);
}

/// Whether a position looks like a small one whose two words are exchanged.
bool looks_exchanged(long position) {
  return position != 0 && position % kWord == 0 && std::abs(exchanged(position)) < kWord / 2;
}

/// Whether a position can only have been read in the right order.
bool shows_order(long position) {
  return position % kWord != 0 && std::abs(exchanged(position)) > 16 * std::abs(position);
}

bool is_garbled(int error) {
  return error == EMBBADCRC || error == EMBBADDATA || error == EMBBADEXC || error == EMBMDATA;
}

/// Whether a driver has understood what it is told, and will not do it another time either.
bool is_refusal(int error) {
  return error == EMBXILFUN || error == EMBXILADD || error == EMBXILVAL || error == EMBXSFAIL;
}

constexpr char kUnplugMaster[] = "another master may be on the line; unplug it";
constexpr char kTellApart[] =
    "two drivers may have one address, or parity, stop bits or the line's ends be wrong";

const char* remedy_for(int error) {
  if (error == ETIMEDOUT) return "look at address, baud, parity, power, and the two wires";
  if (error == EMBBADSLAVE) return kUnplugMaster;
  if (is_garbled(error)) return kTellApart;
  if (error == EMBXILVAL) return "compare the range with its manual, or the register with the map";
  if (is_refusal(error))
    return "the registers may be those of another driver; compare the map with its manual";
  return "unplug the adapter and plug it in again";
}

constexpr int kDataBits = 8;

void close_modbus(modbus_t* context) {
  modbus_close(context);
  modbus_free(context);
}

}  // namespace

Refusal LineErrors::refusal() const {
  std::vector<std::string> remedies;
  if (garbled > 0) remedies.push_back(std::string("garbled: ") + kTellApart);
  if (foreign > 0) remedies.push_back(std::string("from another address: ") + kUnplugMaster);
  if (garbled + unanswered > 0)
    remedies.emplace_back("look at the line's resistors at both ends, its shield and ground");
  return {fmt::format("of {} telegrams {} were garbled, {} answered from another address and {} "
                      "not answered",
                      telegrams, garbled, foreign, unanswered),
          fmt::format("{}", fmt::join(remedies, "; ")), "", Cause::kDevice};
}

ModbusLink::ModbusLink(const ModbusLine& line)
    : line_(line),
      context_(modbus_new_rtu(line.port.c_str(), line.baud, line.parity, kDataBits, line.stop_bits),
               close_modbus) {
  if (!context_ || modbus_connect(context_.get()) != 0) throw WorkError(why_not_opened(line.port));
  if (const auto taken = claim(modbus_get_socket(context_.get()), line.port))
    throw WorkError(*taken);
  constexpr std::uint32_t kSecond_us = 1000000;
  const auto answer_us = static_cast<std::uint32_t>(std::lround(line.answer_s * kSecond_us));
  const bool is_set = modbus_set_response_timeout(context_.get(), answer_us / kSecond_us,
                                                  answer_us % kSecond_us) == 0;
  // Without a time for each byte, that of the answer is for the whole one.
  if (!is_set || modbus_set_byte_timeout(context_.get(), 0, 0) != 0)
    throw WorkError(fmt::format("no answer on Modbus can take {:g} s", line.answer_s),
                    Cause::kInvalid);
  read();
  check_word_order(here_);
}

ModbusLink::~ModbusLink() {
  // Nobody acknowledges a broadcast.
  for (int i = 0; may_move_ && i < (line_.map.start ? kTries : 1); ++i) stop_all_that_hear();
  if (errors_.all() > 0) tell_errors_once();
}

void ModbusLink::tell_errors_once() {
  if (!std::exchange(told_errors_, true)) spdlog::warn(errors_.refusal().at(line_.port).text());
}

std::string ModbusLink::name(std::size_t motor) const {
  return fmt::format("drive {} (address {})", motor + 1, line_.addresses[motor]);
}

template <typename Exchange>
void ModbusLink::exchange(std::size_t motor, const std::string& what, const Exchange& act) {
  int error = 0;
  for (int i = 0; i < kTries && !is_refusal(error); ++i) {
    ++errors_.telegrams;
    modbus_set_slave(context_.get(), line_.addresses[motor]);
    error = act() >= 0 ? 0 : errno;
    if (i > 0 && (error == 0 || is_refusal(error))) drop_late_answers();
    if (error == 0) return;
    errors_.garbled += is_garbled(error) ? 1 : 0;
    errors_.foreign += error == EMBBADSLAVE ? 1 : 0;
    errors_.unanswered += error == ETIMEDOUT ? 1 : 0;
    if (errors_.all() >= kWorthAWord) tell_errors_once();
    modbus_flush(context_.get());
  }
  const Refusal failure{
      fmt::format("{} does not {}: {}", name(motor), what,
                  error == ETIMEDOUT ? fmt::format("no answer within {:.0f} ms, {} times",
                                                   line_.answer_s * 1e3, kTries)
                                     : std::string(modbus_strerror(error))),
      remedy_for(error), "", Cause::kDevice};
  if (is_refusal(error)) throw MachineRefusal(failure);
  throw WorkError(failure);
}

/// What was repeated may be answered twice.
void ModbusLink::drop_late_answers() {
  std::this_thread::sleep_for(std::chrono::duration<double>(line_.answer_s));
  modbus_flush(context_.get());
}

long ModbusLink::read_value(std::size_t motor, const RegisterRead& from, const char* what) {
  std::uint16_t words[2]{};
  exchange(motor, fmt::format("tell its {} in register {:#06x}", what, from.address),
           [&] { return modbus_read_registers(context_.get(), from.address, from.words, words); });
  if (from.words == 1) return words[0];
  const auto high = static_cast<std::uint32_t>(words[line_.map.high_word_first ? 0 : 1]);
  const auto low = static_cast<std::uint32_t>(words[line_.map.high_word_first ? 1 : 0]);
  return static_cast<std::int32_t>(high << 16 | low);
}

std::vector<std::uint16_t> ModbusLink::words_of(const RegisterWrite& write,
                                                const Move& move) const {
  std::vector<std::uint16_t> words;
  for (const RegisterValue& value : write.values) {
    using What = RegisterValue::What;
    const long number = value.what == What::kPosition       ? move.position
                        : value.what == What::kSpeed        ? move.speed
                        : value.what == What::kAcceleration ? move.acceleration
                                                            : value.number;
    const auto bits = static_cast<std::uint32_t>(number);
    const auto high = static_cast<std::uint16_t>(bits >> 16);
    const auto low = static_cast<std::uint16_t>(bits & 0xffff);
    if (value.words == 2) words.push_back(line_.map.high_word_first ? high : low);
    words.push_back(value.words == 1 || line_.map.high_word_first ? low : high);
  }
  return words;
}

int ModbusLink::write_words(int address, const std::vector<std::uint16_t>& words) {
  return words.size() == 1 ? modbus_write_register(context_.get(), address, words[0])
                           : modbus_write_registers(context_.get(), address,
                                                    static_cast<int>(words.size()), words.data());
}

void ModbusLink::write(std::size_t motor, const std::vector<RegisterWrite>& writes,
                       const Move& move, const char* what) {
  for (const RegisterWrite& next : writes) {
    const std::vector<std::uint16_t> words = words_of(next, move);
    exchange(motor,
             fmt::format("{} ({} in register {:#06x})", what, fmt::join(words, " "), next.address),
             [&] { return write_words(next.address, words); });
  }
}

/// Nobody answers a broadcast; the pause is what every driver needs to have read it.
void ModbusLink::broadcast(const RegisterWrite& write) {
  constexpr std::uint8_t kToAll = 0, kWriteOne = 0x06, kWriteMore = 0x10;
  constexpr std::chrono::milliseconds kPause{4};
  const std::vector<std::uint16_t> words = words_of(write, {});
  std::vector<std::uint8_t> telegram{kToAll, words.size() == 1 ? kWriteOne : kWriteMore};
  const auto append = [&](std::size_t word) {
    telegram.push_back(static_cast<std::uint8_t>(word >> 8 & 0xff));
    telegram.push_back(static_cast<std::uint8_t>(word & 0xff));
  };
  append(static_cast<std::size_t>(write.address));
  if (words.size() > 1) {
    append(words.size());
    telegram.push_back(static_cast<std::uint8_t>(2 * words.size()));
  }
  for (const std::uint16_t word : words) append(word);
  ++errors_.telegrams;
  if (modbus_send_raw_request(context_.get(), telegram.data(), static_cast<int>(telegram.size())) <
      0)
    throw WorkError({fmt::format("{} takes nothing: {}", line_.port, modbus_strerror(errno)),
                     remedy_for(errno), "", Cause::kDevice});
  std::this_thread::sleep_for(kPause);
}

/// Where one driver has failed, the others stop; its answer is waited for once at most.
void ModbusLink::stop_all_that_hear() {
  try {
    for (const RegisterWrite& write : line_.map.stop) {
      if (line_.map.start) broadcast(write);
      for (std::size_t i = 0; i < 3 && !line_.map.start; ++i) {
        modbus_set_slave(context_.get(), line_.addresses[i]);
        if (write_words(write.address, words_of(write, {})) < 0) modbus_flush(context_.get());
      }
    }
  } catch (const WorkError&) {
    // The line itself is gone.
  }
}

void ModbusLink::switch_on() {
  failure_.clear();
  for (std::size_t i = 0; i < 3; ++i) write(i, line_.map.switch_on, {}, "switch on");
}

ModbusLink::Move ModbusLink::move_of(std::size_t motor, long target, const MoveTime& time,
                                     DriveLimits limits) const {
  const double counts_per_turn = line_.counts_per_turn[motor];
  const auto way = static_cast<double>(target - here_[motor]);
  Move move{target, 1,
            line_.map.acceleration_number(limits.acceleration_pulses_s2, counts_per_turn)};
  if (way == 0.0) return move;
  const double speed = std::abs(way) / (time.duration_s - time.ramp_s);
  move.speed = line_.map.speed_number(speed, counts_per_turn);
  move.acceleration = line_.map.acceleration_number(speed / time.ramp_s, counts_per_turn);
  return move;
}

void ModbusLink::start(const std::array<Move, 3>& moves) {
  may_move_ = true;
  try {
    for (std::size_t i = 0; i < 3; ++i) write(i, line_.map.move, moves[i], "take a move");
  } catch (const MachineRefusal&) {
    stop();  // others may have begun
    throw;
  }
  if (line_.map.start) broadcast(*line_.map.start);
  started_ = Clock::now();
  turned_.fill(started_);
}

void ModbusLink::go_to(const Pulses& counts, const std::array<DriveLimits, 3>& limits) {
  if (!proven_) return begin_proof(counts, limits);
  const MoveTime time = time_of(counts - here_, limits);
  std::array<Move, 3> moves{};
  for (std::size_t i = 0; i < 3; ++i) moves[i] = move_of(i, counts[i], time, limits[i]);
  target_ = counts;
  start(moves);
}

void ModbusLink::stop() {
  target_.reset();
  search_.reset();
  proof_.reset();
  stop_all_that_hear();  // before one that does not answer is asked again
  std::optional<WorkError> failure;
  for (std::size_t i = 0; i < 3; ++i) {
    try {
      write(i, line_.map.stop, {}, "stop");
    } catch (const WorkError& error) {
      if (!failure) failure = error;
    }
  }
  if (failure) throw WorkError(*failure);
}

void ModbusLink::search_home(int joint, HomeDirection direction) {
  const auto& writes =
      direction == HomeDirection::kForward ? line_.map.home_forward : line_.map.home_reverse;
  if (writes.empty())
    throw WorkError({fmt::format("the map of {} has no search for the home switch", line_.map.name),
                     "add home_reverse or home_forward to it, or name home: {reference: taught}",
                     "", Cause::kMissing});
  may_move_ = true;
  failure_.clear();
  write(joint, writes, {}, "search its home switch");
  search_ = Search{static_cast<std::size_t>(joint)};
  started_ = Clock::now();
}

void ModbusLink::watch_search(long status) {
  const bool moves = line_.map.moving.in(status);
  if (moves || search_->moves) started_ = Clock::now();
  search_->moves = moves;
  search_->has_moved = search_->has_moved || moves;
  search_->is_found = line_.map.homed ? line_.map.homed->in(status) : search_->has_moved;
}

void ModbusLink::end_search() {
  if (!search_->is_found)
    failure_ = fmt::format("{} has not found its home switch: it {}; `enable` clears this",
                           name(search_->driver),
                           search_->has_moved ? "gave up" : "did not begin to move");
  search_.reset();
}

MachineState ModbusLink::read() {
  const Clock::time_point looked = Clock::now();  // answers that are repeated take long
  MachineState state;
  state.on = true;
  const ModbusMap& map = line_.map;
  for (std::size_t i = 0; i < 3; ++i) {
    const long status = read_value(i, map.status, "status");
    state.counts[i] = static_cast<int>(read_value(i, map.position, "position"));
    state.moving = state.moving || map.moving.in(status);
    if (map.moving.in(status))
      state.mover = fmt::format("{} says so by bit {} of its status, {:#06x}", name(i),
                                map.moving.bit, status);
    // A late answer may tell of the status before the move.
    if (map.moving.in(status) || state.counts[i] != here_[i]) turned_[i] = Clock::now();
    if (search_ && search_->driver == i) watch_search(status);
    state.on = state.on && (!map.on || map.on->in(status));
    if (!map.fault || !map.fault->in(status)) continue;
    state.faults.push_back(map.alarm
                               ? fmt::format("{} reports alarm {:#x} in register {:#06x}", name(i),
                                             read_value(i, *map.alarm, "alarm"), map.alarm->address)
                               : fmt::format("{} reports a fault", name(i)));
  }
  if (std::string one = left_behind(state, looked); !one.empty()) {
    state.faults.push_back(std::move(one));
    state.stopped_by_hand = true;  // its own inputs may have stopped it
  }
  if (was_on_ && !state.on) ++losses_;
  was_on_ = state.on;
  state.losses = losses_;
  const bool begins = looked - started_ < kBeginning;
  if (target_ && state.counts != *target_ && begins && state.faults.empty()) state.moving = true;
  if (search_ && begins && state.faults.empty()) state.moving = true;
  if (search_ && !state.moving) end_search();
  if (!failure_.empty()) state.faults.push_back(failure_);
  state.homing = search_.has_value();
  here_ = state.counts;
  if (proof_) {
    follow_proof(state);
    state.moving = true;
  }
  may_move_ = may_move_ && (state.moving || begins);
  return state;
}

/// Returns which driver rests on its way while others move, which leaves the way that was checked;
/// empty when none does.
std::string ModbusLink::left_behind(const MachineState& state, Clock::time_point looked) const {
  constexpr double kTurn = 1.0 / 360.0;  // by as much a closed loop may rest beside its target
  for (std::size_t i = 0; i < 3 && target_ && state.moving; ++i) {
    const int off = std::abs(state.counts[i] - (*target_)[i]);
    if (off > kTurn * line_.counts_per_turn[i] && looked - turned_[i] > kBeginning)
      return fmt::format("{} rests at {} counts on its way to {}, while others move", name(i),
                         state.counts[i], (*target_)[i]);
  }
  return "";
}

void ModbusLink::check_word_order(const Pulses& counts) {
  for (std::size_t i = 0; i < 3; ++i) {
    const long position = counts[i];
    if (!looks_exchanged(position)) continue;
    throw WorkError(
        {fmt::format("{} says that it stands at {}, which is {} with its two words exchanged",
                     name(i), position, exchanged(position)),
         "exchange word_order in the map; if it is right, turn this motor by a count by hand", "",
         Cause::kContradiction});
  }
  // A makes' drivers are alike: one that shows it is enough.
  for (const int position : counts) proven_ = proven_ || shows_order(position);
}

/// A driver at 0 cannot show the order of its words: 1 would be 65,536. So one motor slowly makes a
/// thousandth of a turn, as closed loops take less for none, and is stopped where it goes
/// elsewhere. A ramp in two registers may be exchanged, too: then it and the way are so small that
/// 65,536 times as much is little within a look, and it goes forward: -1 reads alike in both
/// orders.
void ModbusLink::begin_proof(const Pulses& then, const std::array<DriveLimits, 3>& limits) {
  constexpr int kFewest = 2;
  constexpr double kTurn = 1e-3, kPerSecond = 10.0, kGentle_counts_s2 = 10.0;
  std::array<Move, 3> moves{};
  for (std::size_t i = 0; i < 3; ++i) moves[i] = move_of(i, here_[i], {}, limits[i]);
  std::size_t motor = 0;
  (then - here_).cwiseAbs().maxCoeff(&motor);
  const int from = here_[motor];
  const double turn = line_.counts_per_turn[motor];
  int way = std::max(kFewest, static_cast<int>(kTurn * turn)) * (then[motor] < from ? -1 : 1);
  for (const RegisterValue& ramp : line_.map.values_of(RegisterValue::What::kAcceleration)) {
    if (ramp.words == 1) continue;
    way = 1;
    moves[motor].acceleration =
        std::min(moves[motor].acceleration, line_.map.acceleration_number(kGentle_counts_s2, turn));
  }
  moves[motor].position = from + way;
  moves[motor].speed = line_.map.speed_number(kPerSecond * std::abs(way), turn);
  target_.reset();
  proof_ = {motor, from, from + way, then, limits};
  start(moves);
}

void ModbusLink::follow_proof(const MachineState& state) {
  constexpr std::chrono::milliseconds kPatience{1000};
  const auto [motor, from, count, then, limits] = *proof_;
  const long made = long{here_[motor]} - from;
  const bool is_near = std::abs(made) <= 2L * std::abs(count - from);
  const auto since = Clock::now() - started_;
  const bool may_go = state.on && !state.moving && state.faults.empty() && since > kBeginning;
  proven_ = is_near && shows_order(made) && may_go;
  if (proven_) {
    proof_.reset();
    try {
      go_to(then, limits);
    } catch (const MachineRefusal& error) {
      failure_ = fmt::format("{}; `enable` clears this", error.what());
    }
    return;
  }
  if (is_near && since < kPatience) return;
  stop();
  throw MachineRefusal(
      {fmt::format("{} was sent from {} to {} and {} at {}", name(motor), from, count,
                   is_near ? "stays" : "says that it is", here_[motor]),
       is_near ? "the map's `move` or `start` does not start it, `moving` is another bit, or it "
                 "takes this way for none: look in its manual, or turn it by hand while it is off"
               : "the two words of its position may be exchanged: look at word_order in the map",
       "", is_near ? Cause::kDevice : Cause::kContradiction});
}

}  // namespace planar
