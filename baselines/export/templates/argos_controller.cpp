/* $name of swarm-forage $version as a controller of ARGoS 3: link it with controller.o.
 *
 * A robot tells what it hears and from where, so that its neighbours know the bearing back: the board
 * of the e-puck has no compass. Bytes of a message: its own number, how many it heard, LISTENS or
 * SPEAKS (0 before the first), number and bearing [degrees / 2] of each, and the payload. Only who is
 * told his own bearing by a robot that speaks takes a message in.
 */
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <argos3/core/control_interface/ci_controller.h>
#include <argos3/plugins/robots/generic/control_interface/ci_differential_steering_actuator.h>
#include <argos3/plugins/robots/generic/control_interface/ci_differential_steering_sensor.h>
#include <argos3/plugins/robots/generic/control_interface/ci_ground_sensor.h>
#include <argos3/plugins/robots/generic/control_interface/ci_proximity_sensor.h>
#include <argos3/plugins/robots/generic/control_interface/ci_range_and_bearing_actuator.h>
#include <argos3/plugins/robots/generic/control_interface/ci_range_and_bearing_sensor.h>

#include "controller.h"

using namespace argos;

static const UInt8 LISTENS = 1, SPEAKS = 2;
static const size_t HEADER = 3 + 2 * CONTROLLER_SLOTS;
static const double AXLE = $axle; /* [m] */

class CSwarmForageController : public CCI_Controller {
public:
    void Init(TConfigurationNode &t_node) override {
        m_pcWheels = GetActuator<CCI_DifferentialSteeringActuator>("differential_steering");
        m_pcSay = GetActuator<CCI_RangeAndBearingActuator>("range_and_bearing");
        m_pcEncoders = GetSensor<CCI_DifferentialSteeringSensor>("differential_steering");
        m_pcHear = GetSensor<CCI_RangeAndBearingSensor>("range_and_bearing");
        m_pcGround = GetSensor<CCI_GroundSensor>("ground");
        m_pcProximity = GetSensor<CCI_ProximitySensor>("proximity");
        GetNodeAttributeOrDefault(t_node, "seed", m_nSeed, m_nSeed);
        Reset();
    }

    void Reset() override {
        m_nNumber = std::atoi(GetId().c_str() + std::strlen("epuck_"));
        if (controller_init(&m_sController, m_nNumber, m_nSeed))
            THROW_ARGOSEXCEPTION("robot " << GetId() << ": must be epuck_0 to epuck_"
                                          << CONTROLLER_ROBOTS - 1);
    }

    void ControlStep() override {
        controller_readings_t sReadings = Sense();
        std::vector<UInt8> cHeard;
        controller_received_t psReceived[CONTROLLER_SLOTS];
        int nReceived = Receive(psReceived, cHeard);
        controller_command_t sCommand = {};
        if (controller_tick(&m_sController, &sReadings, psReceived, nReceived, &sCommand))
            sCommand = {}; /* stands still and is silent */
        const double fSpeed = 100.0 * CONTROLLER_CRUISE; /* [cm/s] */
        m_pcWheels->SetLinearVelocity(fSpeed * sCommand.wheels[0], fSpeed * sCommand.wheels[1]);
        Say(sCommand, cHeard);
    }

private:
    controller_readings_t Sense() {
        controller_readings_t sReadings;
        /* ARGoS has a ring, 22.5 + 45 k degrees, and gives exp(-distance), or 0 without a hit. */
        for (size_t k = 0; k < 8; k++) {
            const double fValue = m_pcProximity->GetReadings()[7 - k];
            const double fFree = fValue > 0.0 ? -std::log(fValue) : 1.0;
            const double fSeen = (298.701 * fFree - 36.8961) * fFree + 1.08212;
            sReadings.proximity[k] = fFree > 0.05 ? 0.0 : std::fmin(std::fmax(fSeen, 0.0), 1.0);
        }
        for (size_t k = 0; k < 3; k++) /* ARGoS counts from the right */
            sReadings.ground[k] = m_pcGround->GetReadings()[2 - k];
        const auto &sEncoders = m_pcEncoders->GetReading();
        const double fLeft = 0.01 * sEncoders.CoveredDistanceLeftWheel;
        const double fRight = 0.01 * sEncoders.CoveredDistanceRightWheel;
        sReadings.odometry[0] = 0.5 * (fLeft + fRight);
        sReadings.odometry[1] = (fRight - fLeft) / AXLE;
        return sReadings;
    }

    int Receive(controller_received_t *ps_received, std::vector<UInt8> &c_heard) {
        int nReceived = 0;
        for (const auto &sPacket : m_pcHear->GetReadings()) {
            if (sPacket.Data[2] == 0) continue;
            const int nSender = sPacket.Data[0];
            const double fBearing = ToDegrees(sPacket.HorizontalBearing).GetValue();
            if (c_heard.size() / 2 < CONTROLLER_SLOTS) {
                c_heard.push_back(nSender);
                c_heard.push_back(static_cast<UInt8>(std::lround(fBearing / 2.0) & 0xFF));
            }
            if (sPacket.Data[2] != SPEAKS) continue;
            for (int k = 0; k < sPacket.Data[1] && nReceived < CONTROLLER_SLOTS; k++) {
                if (sPacket.Data[3 + 2 * k] != m_nNumber) continue;
                controller_received_t &sOwn = ps_received[nReceived++];
                sOwn.range = 0.01 * sPacket.Range;
                sOwn.bearing = sPacket.HorizontalBearing.GetValue();
                sOwn.bearing_back =
                    ToRadians(CDegrees(2.0 * static_cast<SInt8>(sPacket.Data[4 + 2 * k]))).GetValue();
                sOwn.n_averaged = 1.0f;
                sOwn.sender = nSender;
                UInt8 *pnTo = reinterpret_cast<UInt8 *>(&sOwn.payload);
                for (size_t b = 0; b < CONTROLLER_PAYLOAD_SIZE; b++)
                    pnTo[b] = sPacket.Data[HEADER + b];
            }
        }
        return nReceived;
    }

    void Say(const controller_command_t &s_command, const std::vector<UInt8> &c_heard) {
        std::vector<UInt8> cBytes(HEADER + CONTROLLER_PAYLOAD_SIZE, 0);
        cBytes[0] = m_nNumber;
        cBytes[1] = c_heard.size() / 2;
        cBytes[2] = s_command.is_speaking ? SPEAKS : LISTENS;
        std::copy(c_heard.begin(), c_heard.end(), cBytes.begin() + 3);
        std::memcpy(cBytes.data() + HEADER, &s_command.payload, CONTROLLER_PAYLOAD_SIZE);
        for (size_t b = 0; b < cBytes.size(); b++) m_pcSay->SetData(b, cBytes[b]);
    }

    CCI_DifferentialSteeringActuator *m_pcWheels;
    CCI_RangeAndBearingActuator *m_pcSay;
    CCI_DifferentialSteeringSensor *m_pcEncoders;
    CCI_RangeAndBearingSensor *m_pcHear;
    CCI_GroundSensor *m_pcGround;
    CCI_ProximitySensor *m_pcProximity;
    controller_t m_sController;
    SInt32 m_nNumber = 0;
    UInt32 m_nSeed = 0;
};

REGISTER_CONTROLLER(CSwarmForageController, "swarm_forage")
