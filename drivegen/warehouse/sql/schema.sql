-- Everything below reads what `database.TABLES` names: results (long rows, one number of one scenario each, or of one sample of it
-- where sample is not -1), scenarios, samples, recordings, parameters, costs (times, not repeatable), calls (every call of a language
-- model, or answer from the records, one row each); and methods (what every generator says of itself, one row each: title, kind, the
-- selector whose goals it follows).

-- Every run of a stage that measured: what it read, and how many results it left.
create view runs as
select run, stage, item, method, driver, seed, backend, inputs, count(*) as results
from results
group by all
order by stage, item, method;

-- The results of scenes as a whole.
create view scene_results as from results where sample = -1;

-- Those that are averaged: errors grow with the time that is foreseen, so of runs that wrote down how many `steps` scenes have only
-- the scenes of the length that most have, of several such lengths the largest (`core.intervals.usual_length`); else all.
create view averaged_results as
with lengths as (select run, scenario, value as steps from scene_results where metric = 'steps'),
usual as (select run, steps from lengths group by run, steps
          qualify row_number() over (partition by run order by count(*) desc, steps desc) = 1),
others as (from lengths anti join usual using (run, steps))
from scene_results anti join others using (run, scenario);

-- One row a metric, method and driver: the numbers of the report's tables, before intervals. `results` are the values behind a mean:
-- more than scenarios where an item was run with several seeds.
create view metrics as
select stage, item, method, driver, metric,
       count(distinct scenario) as scenarios, count(*) as results, avg(value) as mean, median(value) as median,
       stddev_samp(value) as spread, min(value) as least, max(value) as most
from averaged_results
where metric not like 'label.%' and metric not like 'manoeuvre.%'
group by all;

-- Every run of a driver through a sample: how it ended and how it drove. `kind` is who hit whom, null without a collision,
-- `partner` the other vehicle's index in the scenario, `counted` whether it is a collision that says something of the driver, `made_by` the stage that made the
-- traffic (its section of parameters says how), `shard` where that lies, `recording` one that shows it: other stages record how the traffic alone moves.
create view drives as
with runs_of_drivers as (
    select stage, item, method, driver, scenario, sample, reactive,
           bool_or(value = 1) filter (metric = 'collision') as collision,
           max(split_part(metric, '.', 3)) filter (metric like 'impact.kind.%') as kind,
           round(max(value) filter (metric = 'impact.step') / 10, 1) as seconds,
           max(value) filter (metric = 'impact.partner')::int as partner,
           bool_or(value = 1) filter (metric = 'collision.at_fault') as at_fault,
           bool_or(value = 1) filter (metric = 'collision.counted') as counted,
           bool_or(value = 1) filter (metric = 'collision.artefact') as artefact,
           bool_or(value = 1) filter (metric = 'left_map') as left_map,
           max(value) filter (metric = 'distance') as distance,
           max(value) filter (metric = 'absolute_acceleration') as absolute_acceleration
    from (select * exclude metric, starts_with(metric, 'reactive.') as reactive, regexp_replace(metric, '^reactive[.]', '') as metric
          from results where driver <> '' and sample >= 0)
    group by all)
select d.* exclude (artefact) replace (coalesce(counted, collision and not artefact) as counted),
       s.stage as made_by, s.shard, r.href as recording
from runs_of_drivers d
left join samples s on s.method = d.method and s.scenario = d.scenario and s.sample = d.sample
                   and (s.stage = 'corner') = (d.stage = 'corner') and (d.stage <> 'corner' or s.item = d.item)
left join recordings r on d.stage = 'corner' and r.stage = s.stage and r.item = s.item and r.scenario = d.scenario and r.sample = d.sample;

-- Those that ended in a collision.
create view crashes as select * exclude (collision, left_map) from drives where collision;

-- The paper's four realism columns and the rates of generated traffic, one row a method.
create view scenario_quality as
pivot (select method, metric, value from averaged_results where stage = 'evaluate' and metric in (
    'min_sade', 'min_sfde', 'mean_sade', 'mean_sfde', 'collision_per_vehicle', 'off_road_per_vehicle', 'illegal_per_vehicle'))
on metric in ('min_sade', 'min_sfde', 'mean_sade', 'mean_sfde', 'collision_per_vehicle', 'off_road_per_vehicle', 'illegal_per_vehicle')
using avg(value) group by method;

-- What kind of scene each scenario is: one row a scenario and aspect (road, manoeuvre, conflict, density).
create view labels as
select distinct scenario, split_part(metric, '.', 2) as aspect, split_part(metric, '.', 3) as label
from scene_results
where metric like 'label.%';

-- Every metric by kind of scene, e.g. min_sade at signalised junctions.
create view metrics_by_label as
select l.aspect, l.label, r.stage, r.method, r.driver, r.metric, count(distinct scenario) as scenarios, avg(r.value) as mean
from averaged_results r join labels l using (scenario)
where r.metric not like 'label.%' and r.metric not like 'manoeuvre.%'
group by all;

-- What it took, with rates where both a time and a number of things are known.
create view cost_per_item as
select stage, item, sum(value) filter (name = 'cpu_seconds') as cpu_seconds, sum(value) filter (name = 'scenarios') as scenarios,
       cpu_seconds / scenarios as cpu_seconds_per_scenario
from costs
group by all;

-- What 1000 scenarios cost by each method: samples from the first frame on, goals, models' loading and the checker included;
-- choosing goals is a stage of its own for those that follow a selector's. Measured at the size of the run, where loading
-- weighs most: an upper bound. Null is what did not run here but was restored from the cache. What a GPU took is not measured.
create view cost_of_methods as
with took as (
    select stage, item, max(value) filter (name = 'cpu_seconds') as cpu,
           max(value) filter (name = 'peak_megabytes') as megabytes
    from costs group by stage, item),
seen as (select method, count(distinct scenario) as scenarios from scene_results where stage = 'evaluate' group by method)
select seen.method, scenarios,
       if(goals is null, 0, 1000 * chosen.cpu / scenarios) as of_it_choosing_goals,
       1000 * made.cpu / scenarios + of_it_choosing_goals as cpu_seconds_per_1000,
       made.megabytes as peak_megabytes
from seen
left join took made on made.item = seen.method and made.stage like 'rollout%'
left join methods on methods.method = seen.method
left join took chosen on chosen.stage = 'goals' and chosen.item = methods.goals
order by seen.method;

-- What training cost, model by model; GPU seconds, of whatever the stage did there, are null where it used none.
create view cost_of_training as
select stage, item, max(value) filter (name = 'cpu_seconds') as cpu_seconds,
       sum(value) filter (name in ('training_gpu_seconds', 'tuning_gpu_seconds', 'planning_gpu_seconds')) as gpu_seconds
from costs where stage like 'train%' group by stage, item order by stage, item;

-- What language models were asked and what it took: one row a role, model and wording. Dollars are null where a price is unknown.
create view language_model_calls as
select role, model, prompt_version, count(*) as calls, count(*) filter (replayed) as replayed,
       count(*) filter (outcome = 'answered') as answered, count(*) filter (outcome = 'asked again') as asked_again,
       sum(input_tokens) as input_tokens, sum(output_tokens) as output_tokens, sum(retries) as retries,
       if(bool_or(cost = 'unknown'), null, sum(try_cast(cost as double))) as dollars,
       sum(latency) as seconds
from calls
group by all;
