"""A hand-written SUMO network for tests, small enough to know every link of it."""

CROSS = """<net version="1.20">
  <location netOffset="0.00,0.00" convBoundary="0,0,200,200"/>
  <edge id=":c_0" function="internal"><lane id=":c_0_0" index="0" speed="10" length="20" shape="90,98.4 110,98.4"/></edge>
  <edge id=":c_1" function="internal"><lane id=":c_1_0" index="0" speed="7" length="9" shape="90,98.4 97,102,0.5"/></edge>
  <edge id=":c_2" function="internal"><lane id=":c_2_0" index="0" speed="7" length="9" shape="97,102 98.4,110"/></edge>
  <edge id=":c_3" function="internal"><lane id=":c_3_0" index="0" speed="10" length="20" shape="101.6,90 101.6,110"/></edge>
  <edge id=":c_c0" function="crossing"><lane id=":c_c0_0" index="0" allow="pedestrian" speed="1" length="8" width="4"
    shape="88,94 88,106"/></edge>
  <edge id=":c_w0" function="walkingarea"><lane id=":c_w0_0" index="0" allow="pedestrian" speed="1" length="1"
    shape="88,90 89,91 90,90"/></edge>
  <edge id="w_in" from="w" to="c"><lane id="w_in_0" index="0" allow="pedestrian" speed="2" length="90" width="2"
    shape="0,93 90,93"/>
    <lane id="w_in_1" index="1" speed="13.89" length="90" shape="0,95.2 90,95.2"/>
    <lane id="w_in_2" index="2" speed="13.89" length="90" shape="0,98.4 90,98.4" changeRight="emergency"/></edge>
  <edge id="w_out" from="c" to="w"><lane id="w_out_0" index="0" speed="13.89" length="90" shape="90,101.6 0,101.6"/></edge>
  <edge id="e_out" from="c" to="e"><lane id="e_out_0" index="0" speed="13.89" length="90" shape="110,98.4 200,98.4"/></edge>
  <edge id="n_out" from="c" to="n"><lane id="n_out_0" index="0" allow="bus taxi" speed="13.89" length="90" width="3.5"
    shape="100,110 100,200"/></edge>
  <edge id="s_in" from="s" to="c"><lane id="s_in_0" index="0" allow="bicycle" speed="8" length="90" width="1.5"
    shape="101.6,0 101.6,90"/></edge>
  <edge id="rails" from="a" to="b"><lane id="rails_0" index="0" allow="rail" speed="30" length="90" shape="0,150 90,150"/></edge>
  <tlLogic id="T" type="static" programID="0" offset="5">
    <phase duration="30" state="Gr"/><phase duration="5" state="yr"/><phase duration="25" state="rG"/>
  </tlLogic>
  <junction id="c" type="traffic_light" x="100" y="100" incLanes="w_in_1 w_in_2 s_in_0" intLanes=":c_0_0 :c_3_0"
    shape="90,90 110,90 110,110 90,110"/>
  <junction id="w" type="dead_end" x="0" y="98" incLanes="" intLanes="" shape="0,93 0,103"/>
  <connection from="w_in" to="e_out" fromLane="2" toLane="0" via=":c_0_0" tl="T" linkIndex="0" dir="s" state="O"/>
  <connection from="w_in" to="n_out" fromLane="2" toLane="0" via=":c_1_0" dir="l" state="m"/>
  <connection from="s_in" to="n_out" fromLane="0" toLane="0" via=":c_3_0" tl="T" linkIndex="1" dir="s" state="O"/>
  <connection from="w_in" to="nowhere" fromLane="1" toLane="0" dir="s" state="M"/>
  <connection from="w_in" to="rails" fromLane="1" toLane="0" dir="s" state="M"/>
  <connection from="w_in" to="w_out" fromLane="1" toLane="0" dir="t" state="s"/>
  <connection from=":c_0" to="e_out" fromLane="0" toLane="0" dir="s" state="M"/>
  <connection from=":c_1" to="n_out" fromLane="0" toLane="0" via=":c_2_0" dir="l" state="m"/>
  <connection from=":c_2" to="n_out" fromLane="0" toLane="0" dir="l" state="M"/>
</net>"""
"""From the west straight on under light T, left through two internal lanes giving way; a bicycle lane from the south."""
