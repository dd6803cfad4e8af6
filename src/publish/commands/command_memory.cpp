#include "commands/command_memory.hpp"

#include <utility>

namespace takt::publish {

CommandMemory::Entry* CommandMemory::find(const std::string& id) {
    const auto found = entries_.find(id);
    return found == entries_.end() ? nullptr : &found->second;
}

void CommandMemory::add(const std::string& id, bool accepted, Entry entry) {
    auto& order = accepted ? accepted_ : refused_;
    while (order.size() >= kMost) {
        std::string oldest = std::move(order.front());
        order.pop_front();
        if (!accepted || entries_.at(oldest).answer)
            entries_.erase(oldest);
        else
            order.push_back(std::move(oldest));
    }
    order.push_back(id);
    entries_.insert_or_assign(id, std::move(entry));
}

}  // namespace takt::publish
