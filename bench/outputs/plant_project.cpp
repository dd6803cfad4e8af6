#include "plant_project.hpp"

#include <fmt/format.h>

#include <fstream>

#include "../scale/field.hpp"

namespace takt::bench {

void write_project(const std::string& path, const PlantProject& project) {
    std::ofstream file(path);
    file << "takt: 1\nlines:\n";
    for (std::size_t i = 0; i < project.devices; ++i) {
        file << fmt::format(
            "- name: L{0}\n  transport: tcp\n  framing: tcp\n  host: {1}\n  tcp_port: {2}\n  devices:\n"
            "  - name: D{0}\n    address: 1\n    poll_period: 1s\n    response_timeout: 300ms\n    "
            "variables:\n",
            i, device_address(i), project.field_port);
        for (std::size_t v = 0; v < project.variables; ++v)
            file << fmt::format("    - {{name: V{}-{}, type: int16, register: {}, read: 3}}\n", i, v, v);
    }
    file << fmt::format(
        "outputs:\n- name: {}\n  transport: mqtt\n  brokers: [\"mqtt://127.0.0.1:{}\"]\n"
        "  topic: plant/{{device}}/{{variable}}\n",
        kOutputName, project.broker_port);
}

}  // namespace takt::bench
