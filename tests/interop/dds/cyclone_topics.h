/* Every topic of the house as a stranger sees it: Cyclone's own types, made by its compiler from idl/, and
 * the quality of service that the README of gateway/bus promises. */
#ifndef CYCLONE_TOPICS_H
#define CYCLONE_TOPICS_H

#include <stddef.h>

#include "dds/dds.h"

enum topic_class { TOPIC_SENSOR, TOPIC_COMMAND, TOPIC_STATE, TOPIC_EVENT, TOPIC_REQUEST };

struct topic {
  const char* name;
  const dds_topic_descriptor_t* type;
  enum topic_class class;
  const char* partition; /* NULL: the default one */
};

extern const struct topic every_topic[];
extern const size_t topic_count;

/* Ends the program with the reason when an entity was not made. */
dds_entity_t checked(dds_entity_t entity, const char* what);
dds_entity_t participant_of(dds_domainid_t domain);
dds_entity_t reader_of(dds_entity_t participant, const struct topic* topic);
dds_entity_t writer_of(dds_entity_t participant, const struct topic* topic);
/* The row of this name. */
const struct topic* topic_named(const char* name);
/* Ends the program when Cyclone says that somebody asks or offers another quality of service. */
void refuse_incompatible_reader(dds_entity_t reader, const char* topic);
void refuse_incompatible_writer(dds_entity_t writer, const char* topic);

#endif
