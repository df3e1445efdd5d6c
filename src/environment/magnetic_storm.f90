!> How far the geomagnetic field departs from a model of its main part in a magnetic storm.
module gracecg_environment_magnetic_storm
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: NANOTESLA
    implicit none
    private
    public :: storm_field_deviation

contains

    !> Deviation of the field by the planetary index, CSR-TM-00-01 eq. (6.1): 4 exp[(Kp + 1.6)/1.75] nT, in T.
    !> The report gives it for the magnitude, puts in Kp = 2.5 (42 nT) and, with the electrojets in mind, then
    !> assumes 150 nT on each axis, which is what (6.1) gives at Kp = 4.74.
    elemental real(dp) function storm_field_deviation(kp) result(deviation)
        real(dp), intent(in) :: kp      !! 0 to 9

        deviation = 4*exp((kp + 1.6_dp)/1.75_dp)*NANOTESLA
    end function storm_field_deviation
end module gracecg_environment_magnetic_storm
