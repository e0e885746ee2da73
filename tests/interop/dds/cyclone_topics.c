#include "cyclone_topics.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ArmCommand.h"
#include "ArmState.h"
#include "Bodies.h"
#include "Control.h"
#include "Estimate.h"
#include "Event.h"
#include "Health.h"
#include "Mode.h"
#include "ModeRequest.h"
#include "Mru.h"
#include "Reference.h"
#include "Score.h"
#include "SimControl.h"
#include "Timing.h"
#include "TruthWorld.h"
#include "WinchCommand.h"
#include "WinchState.h"

const struct topic every_topic[] = {
    {"motionlab/mru", &motionlab_Mru_desc, TOPIC_SENSOR, NULL},
    {"motionlab/bodies", &motionlab_Bodies_desc, TOPIC_SENSOR, NULL},
    {"motionlab/arm_state", &motionlab_ArmState_desc, TOPIC_SENSOR, NULL},
    {"motionlab/arm_command", &motionlab_ArmCommand_desc, TOPIC_COMMAND, NULL},
    {"motionlab/winch_state", &motionlab_WinchState_desc, TOPIC_SENSOR, NULL},
    {"motionlab/winch_command", &motionlab_WinchCommand_desc, TOPIC_COMMAND, NULL},
    {"motionlab/estimate", &motionlab_Estimate_desc, TOPIC_SENSOR, NULL},
    {"motionlab/control", &motionlab_Control_desc, TOPIC_SENSOR, NULL},
    {"motionlab/reference", &motionlab_Reference_desc, TOPIC_STATE, NULL},
    {"motionlab/mode", &motionlab_Mode_desc, TOPIC_STATE, NULL},
    {"motionlab/mode_request", &motionlab_ModeRequest_desc, TOPIC_REQUEST, NULL},
    {"motionlab/health", &motionlab_Health_desc, TOPIC_STATE, NULL},
    {"motionlab/timing", &motionlab_Timing_desc, TOPIC_STATE, NULL},
    {"motionlab/score", &motionlab_Score_desc, TOPIC_STATE, NULL},
    {"motionlab/event", &motionlab_Event_desc, TOPIC_EVENT, NULL},
    {"truth/world", &motionlab_TruthWorld_desc, TOPIC_SENSOR, "truth"},
    {"sim/control", &motionlab_SimControl_desc, TOPIC_REQUEST, "truth"},
};
const size_t topic_count = sizeof every_topic / sizeof every_topic[0];

dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "cyclone: %s: %s\n", what, dds_strretcode(-entity));
    exit(2);
  }
  return entity;
}

dds_entity_t participant_of(dds_domainid_t domain) {
  return checked(dds_create_participant(domain, NULL, NULL), "participant");
}

static dds_qos_t* qos_of(const struct topic* topic) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos,
                       topic->class == TOPIC_SENSOR ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE,
                       DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
  if (topic->class == TOPIC_STATE || topic->class == TOPIC_EVENT) {
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  }
  if (topic->class == TOPIC_COMMAND) dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(200));
  return qos;
}

static dds_entity_t in_partition(dds_entity_t participant, const struct topic* topic, int writes) {
  dds_qos_t* partition = dds_create_qos();
  if (topic->partition) dds_qset_partition1(partition, topic->partition);
  const dds_entity_t group = checked(writes ? dds_create_publisher(participant, partition, NULL)
                                            : dds_create_subscriber(participant, partition, NULL),
                                     topic->name);
  dds_delete_qos(partition);
  return group;
}

static dds_entity_t topic_of(dds_entity_t participant, const struct topic* topic) {
  return checked(dds_create_topic(participant, topic->type, topic->name, NULL, NULL), topic->name);
}

dds_entity_t reader_of(dds_entity_t participant, const struct topic* topic) {
  dds_qos_t* qos = qos_of(topic);
  const dds_entity_t reader =
      checked(dds_create_reader(in_partition(participant, topic, 0), topic_of(participant, topic), qos, NULL),
              topic->name);
  dds_delete_qos(qos);
  return reader;
}

dds_entity_t writer_of(dds_entity_t participant, const struct topic* topic) {
  dds_qos_t* qos = qos_of(topic);
  /* Our readers ask for three periods of 5 ms, less a rounding. */
  if (topic->class == TOPIC_SENSOR) dds_qset_deadline(qos, DDS_MSECS(10));
  const dds_entity_t writer =
      checked(dds_create_writer(in_partition(participant, topic, 1), topic_of(participant, topic), qos, NULL),
              topic->name);
  dds_delete_qos(qos);
  return writer;
}

const struct topic* topic_named(const char* name) {
  for (size_t i = 0; i < topic_count; ++i) {
    if (strcmp(every_topic[i].name, name) == 0) return &every_topic[i];
  }
  fprintf(stderr, "cyclone: there is no topic %s\n", name);
  exit(2);
}

static void refuse(uint32_t count, uint32_t policy, const char* topic) {
  if (count == 0) return;
  fprintf(stderr, "cyclone: %s: incompatible quality of service, policy %u\n", topic, (unsigned)policy);
  exit(3);
}

void refuse_incompatible_reader(dds_entity_t reader, const char* topic) {
  dds_requested_incompatible_qos_status_t status;
  if (dds_get_requested_incompatible_qos_status(reader, &status) == DDS_RETCODE_OK) {
    refuse(status.total_count, status.last_policy_id, topic);
  }
}

void refuse_incompatible_writer(dds_entity_t writer, const char* topic) {
  dds_offered_incompatible_qos_status_t status;
  if (dds_get_offered_incompatible_qos_status(writer, &status) == DDS_RETCODE_OK) {
    refuse(status.total_count, status.last_policy_id, topic);
  }
}
