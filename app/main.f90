program try
 use gracecg_kinds
 use gracecg_error
 use gracecg_calibration_case
 use gracecg_report_cases
 use gracecg_case_models
 use gracecg_equations_of_motion
 use gracecg_runge_kutta
 implicit none
 type(calibration_case_t) :: c, c2
 type(error_t), allocatable :: e
 integer :: i, k, v, sat
 real(dp) :: t, y(13), sc(13), te, d(3), u(3,3)
 type(satellite_dynamics_t) :: dyn
 character(5) :: sn
 sc=[1e7_dp,1e7_dp,1e7_dp,1e4_dp,1e4_dp,1e4_dp,1e-3_dp,1e-3_dp,1e-3_dp,1._dp,1._dp,1._dp,1._dp]
 do sat=1,2
 sn=merge('front','back ',sat==1)
 do v=1,7
 call report_case(trim(sn)//'-1', c, e)
 if (v==2) c%height_above='sphere'
 if (v==3) c%density_model='none'
 if (v==6) c%gravity_degree=70
 if (v==6) c%gravity_order=70
 call build_dynamics(c, dyn, e)
 dyn%rods%count = 0
 if (v==4) dyn%with_solar_radiation=.false.
 if (v==5) dyn%with_earth_radiation=.false.
 if (v==7) then
  dyn%with_solar_radiation=.false.
  dyn%with_earth_radiation=.false.
  dyn%with_drag=.false.
 end if
 do i=2,3
   call report_case(trim(sn)//'-'//achar(48+i), c2, e)
   te=merge(1400._dp,2658._dp,i==2)
   y = initial_state(c); t=0
   call rkf78_integrate(dyn, t, y, te, 1e-13_dp, sc, k, e)
   d=c2%position-y(1:3)
   if (sat==1.and.i==2) d(2)=-50.3762086975-y(2)
   u(:,1)=y(1:3)/norm2(y(1:3)); u(:,2)=y(4:6)/norm2(y(4:6)); u(:,3)=[ &
u(2,1)*u(3,2)-u(3,1)*u(2,2),u(3,1)*u(1,2)-u(1,1)*u(3,2),u(1,1)*u(2,2)-u(2,1)*u(1,2)]
   print '(a,i3,i3,a,3f10.4, a, 3es12.3)', sn, v, i, '  R T N (m) ', matmul(d,u), ' v ', matmul(c2%velocity-y(4:6),u)
 end do
 end do
 end do
end program
