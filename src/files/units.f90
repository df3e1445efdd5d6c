!> The names of the columns of tables tell the unit: sigma_x_mm, time_s, ax_m_s2.
module gracecg_files_units
    implicit none
    private
    public :: unit_of_column

    !> How a name ends, and the unit that it means; of two endings that fit, the earlier
    character(16), parameter :: UNITS(2, 32) = reshape([character(16) :: &
        '_m_s2_sqrt_hz', 'm/s^2/sqrt(Hz)', &
        '_rad_s2', 'rad/s^2', '_rad_s', 'rad/s', '_deg_s', 'deg/s', '_m2_s4_hz', 'm^2/s^4/Hz', &
        '_m2_s2', 'm^2/s^2', '_m_s3', 'm/s^3', '_m_s2', 'm/s^2', '_m_s', 'm/s', '_kg_m3', 'kg/m^3', &
        '_per_m3', '1/m^3', '_n_m', 'N m', '_a_m2', 'A m^2', '_a_m', 'A/m', '_arcsec', 'arcsec', &
        '_kelvin', 'K', '_tesla', 'T', '_nt', 'nT', '_rad', 'rad', '_deg', 'deg', '_hz', 'Hz', &
        '_sfu', 'sfu', '_au', 'au', '_km', 'km', '_mm2', 'mm^2', '_mm', 'mm', '_um', 'um', '_m', 'm', &
        '_percent', '%', '_kg', 'kg', '_h', 'h', '_s', 's'], [2, 32])

contains

    !> The unit that the name of a column ends with; blank: it has none, or is no number.
    pure function unit_of_column(name) result(unit)
        character(*), intent(in) :: name    !! Of a column: 'dx_mm'
        character(len(UNITS)) :: unit

        integer :: i, first

        unit = ''
        do i = 1, size(UNITS, 2)
            first = len_trim(name) - len_trim(UNITS(1, i)) + 1
            if (first < 2) cycle
            if (name(first:len_trim(name)) /= UNITS(1, i)) cycle
            unit = UNITS(2, i)
            return
        end do
    end function unit_of_column
end module gracecg_files_units
