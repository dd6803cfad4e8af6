#include "takt/line/driver.hpp"
#include "takt/sim/simulated_line.hpp"

namespace takt::line {
namespace {

class OwnSimulation final : public Driver {
public:
    OwnSimulation(Loop& loop, const model::Line& line, Engine& engine, const DriverOptions& options)
        : simulation_(line, engine), driver_(run_simulated(loop, simulation_, line.name, options)) {}

    void poke() override { driver_->poke(); }
    bool up() const override { return driver_->up(); }
    const std::string& name() const override { return driver_->name(); }
    DriverCounters counters() const override { return driver_->counters(); }

private:
    sim::SimulatedLine simulation_;
    std::unique_ptr<Driver> driver_;
};

}  // namespace

Result<std::unique_ptr<Driver>> open_line(Loop& loop, const model::Line& line, Engine& engine,
                                          const DriverOptions& options) {
    switch (line.transport) {
        case model::Transport::serial: {
            SerialSettings settings;
            settings.path = line.port;
            settings.format = line.format;
            settings.rs485 = line.rs485;
            return open_serial(loop, settings, engine, options);
        }
        case model::Transport::tcp:
        case model::Transport::tls: {
            DriverOptions tcp = options;
            if (line.transport == model::Transport::tls) {
                TAKT_TRY(tcp.tls, tls::Context::load(tls::Side::client, line.tls));
            }
            tcp.acknowledge_at_once = line.framing != wire::Framing::tcp;
            return connect_tcp(loop, line.port, line.tcp_port, engine, tcp);
        }
        case model::Transport::simulated: return std::make_unique<OwnSimulation>(loop, line, engine, options);
    }
    return fail(Code::unsupported, "transport");
}

}  // namespace takt::line
