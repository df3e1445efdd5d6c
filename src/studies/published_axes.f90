!> The limits of the axes that CSR-TM-00-01 prints in its Figures 6.1-6.6.
module gracecg_studies_published_axes
    use gracecg_base_kinds, only: dp
    use gracecg_files_data_table, only: data_table_t
    use gracecg_studies_table_axis_limits, only: LIMIT_FIGURE, LIMIT_SATELLITE, LIMIT_PANEL, LIMIT_AXIS, LIMIT_LOW, &
        LIMIT_HIGH, LIMIT_STEP
    implicit none
    private
    public :: published_axis, published_axes_table

contains

    !> Lower and upper limit of one panel, and the distance of its tick marks: nT in Figure 6.1, rad/s^2 in 6.4, m in the
    !> others. All are 0 when the report has no such panel.
    pure function published_axis(figure, satellite, panel, axis) result(limits)
        character(*), intent(in) :: figure      !! '6.1' to '6.6'
        character(*), intent(in) :: satellite   !! 'front' or 'back'
        character(*), intent(in) :: panel       !! Algorithm; 'field' in Figure 6.1, 'acceleration' in 6.4
        character(*), intent(in) :: axis        !! 'x', 'y', 'z'; 'all' in Figures 6.1 and 6.4
        real(dp) :: limits(3)

        integer :: i

        limits = 0
        i = findloc(LIMIT_FIGURE == figure .and. LIMIT_SATELLITE == satellite .and. LIMIT_PANEL == panel .and. &
                    LIMIT_AXIS == axis, .true., 1)
        if (i > 0) limits = [LIMIT_LOW(i), LIMIT_HIGH(i), LIMIT_STEP(i)]
    end function published_axis

    !> All panels: nT in Figure 6.1, rad/s^2 in 6.4, m in the others.
    function published_axes_table() result(table)
        type(data_table_t) :: table

        integer :: i

        call table%columns_of('figure,satellite,panel,axis,low,high,step')
        do i = 1, size(LIMIT_LOW)
            call table%add(LIMIT_FIGURE(i))
            call table%add(LIMIT_SATELLITE(i))
            call table%add(LIMIT_PANEL(i))
            call table%add(LIMIT_AXIS(i))
            call table%add([LIMIT_LOW(i), LIMIT_HIGH(i), LIMIT_STEP(i)])
        end do
    end function published_axes_table
end module gracecg_studies_published_axes
