import sys, time

import bpy, cageform, numpy as np
cageform.register()
bpy.ops.object.select_all(action='DESELECT')
if 'Cube' in bpy.data.objects: bpy.data.objects.remove(bpy.data.objects['Cube'])
bpy.ops.mesh.primitive_monkey_add()
m=bpy.context.object
mod=m.modifiers.new('s','SUBSURF'); mod.levels=3; bpy.ops.object.modifier_apply(modifier='s')
print('vertices',len(m.data.vertices))
t=time.time(); print(bpy.ops.cageform.make_cage(vertices=60)); print('make',time.time()-t)
bpy.context.view_layer.objects.active=m
b=m.cageform.bindings[0]; print(b.cage, len(b.cage.data.vertices))
t=time.time(); print(bpy.ops.cageform.bind()); print('bind',time.time()-t); print(b.report, '|', b.fault)
cage=b.cage
co=cageform.deform.positions(cage.data); co[:,2]+=np.where(co[:,0]>0,0.5,0).astype(np.float32); cage.data.vertices.foreach_set('co',co.ravel()); cage.data.update()
t=time.time(); bpy.context.view_layer.update(); print('update',time.time()-t)
key=m.data.shape_keys.key_blocks['Cageform']; n=np.empty(3*len(m.data.vertices),np.float32); key.data.foreach_get('co',n)
print('moved', np.abs(n.reshape(-1,3)-cageform.rest_positions(m)).max())
print('--- more')
# playback: key the cage by a shape key
def where():
    key=m.data.shape_keys.key_blocks['Cageform']; n=np.empty(3*len(m.data.vertices),np.float32); key.data.foreach_get('co',n); return n.reshape(-1,3)
cage.shape_key_add(name='Basis'); k=cage.shape_key_add(name='up')
c2=np.empty(3*len(cage.data.vertices),np.float32); k.data.foreach_get('co',c2); c2=c2.reshape(-1,3); c2[:,1]-=0.4*(c2[:,2]>0.3); k.data.foreach_set('co',c2.ravel())
k.value=0; k.keyframe_insert('value',frame=1); k.value=1; k.keyframe_insert('value',frame=20)
s=bpy.context.scene; s.frame_start,s.frame_end=1,20
t=time.time()
for f in range(1,21): s.frame_set(f)
print('ms a frame',(time.time()-t)/20*1000); a=where()
s.frame_set(1); print('moved by playback', np.abs(where()-a).max())
# armature? edit mode of the cage
bpy.context.view_layer.objects.active=cage; 
# write
bpy.context.view_layer.objects.active=m
print(bpy.ops.cageform.write_figure(filepath='/tmp/suz.figure'))
f=cageform.library.open('/tmp/suz.figure'); print(f.points,f.handles,f.clips, f.has_normals)
print(bpy.ops.cageform.bake(step=5)); print([k.name for k in m.data.shape_keys.key_blocks])
# save and open
m.data.shape_keys.key_blocks['Cageform'].mute=False
bpy.ops.wm.save_as_mainfile(filepath='/tmp/suz.blend'); 
before=where().copy()
bpy.ops.wm.open_mainfile(filepath='/tmp/suz.blend')
m=bpy.data.objects['Suzanne']; cage=m.cageform.bindings[0].cage
print('opened', m.cageform.bindings[0].report, np.abs(where()-before).max())
# pins
bpy.context.view_layer.objects.active=m
for v in m.data.vertices: v.select=False
z=cageform.rest_positions(m); top=int(z[:,2].argmax()); low=int(z[:,2].argmin())
m.data.vertices[top].select=True; m.data.vertices[low].select=True
t=time.time(); print(bpy.ops.cageform.add_pins()); print('pins',time.time()-t,[p.vertex for p in m.cageform.bindings[0].pins])
cage.shape_key_clear() if hasattr(cage,'shape_key_clear') else None
e=[p.empty for p in m.cageform.bindings[0].pins if p.vertex==top][0]
x0=where()[top].copy(); e.location.x+=0.5
bpy.context.view_layer.update(); print('pin moved', where()[top]-x0)
# wrong inputs
def tries(what, f):
    try: print(what, f())
    except RuntimeError as err: print(what,'->',str(err).strip())
b=m.cageform.bindings[0]
b.cage=None; tries('no cage', bpy.ops.cageform.bind)
import bmesh
bpy.ops.mesh.primitive_cube_add(size=6); c=bpy.context.object; bm=bmesh.new(); bm.from_mesh(c.data); bm.faces.ensure_lookup_table(); bmesh.ops.delete(bm,geom=[bm.faces[0],bm.faces[1],bm.faces[2]],context='FACES_ONLY'); bm.to_mesh(c.data)
bpy.context.view_layer.objects.active=m; b.cage=c; tries('open cage', bpy.ops.cageform.bind); print(b.fault)
b.cage=m; tries('itself', bpy.ops.cageform.bind)
